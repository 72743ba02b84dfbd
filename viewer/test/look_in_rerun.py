"""Opens a file in Rerun without a window, and looks whether the scene is in the picture.

    python look_in_rerun.py RERUN FILE PICTURE
"""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from PIL import Image
from rerun.experimental import ViewerClient

rerun, file, picture = sys.argv[1:4]
port = 9917
words = [rerun, "--headless", "--port", str(port), "--bind", "127.0.0.1", "--window-size", "1300x800", file]
viewer = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True)
try:
    time.sleep(12)
    Path(picture).unlink(missing_ok=True)
    ViewerClient(f"127.0.0.1:{port}").save_screenshot(picture)
    for _ in range(100):
        time.sleep(0.2)
        if Path(picture).exists() and Path(picture).stat().st_size > 1000:
            break
finally:
    # the command starts the viewer as another process
    os.killpg(viewer.pid, signal.SIGKILL)
    said = viewer.communicate()[0]
assert "without loading" not in said, said
time.sleep(0.5)
pixels = list(Image.open(picture).convert("RGB").reduce(2).get_flattened_data())


def share(is_one):
    return sum(map(is_one, pixels)) / len(pixels)


paper = share(lambda p: all(abs(c - 245) < 6 for c in p))
walls = share(lambda p: max(p) - min(p) < 14 and 50 < p[0] < 150)
shirt = share(lambda p: p[2] > p[0] + 25 and p[2] > p[1] + 15 and p[2] < 190)
assert paper > 0.15 and walls > 0.01 and shirt > 0.0001, f"{picture}: no scene: {paper:.3f} {walls:.3f} {shirt:.5f}"
print(f"{Path(file).name}: the scene is drawn; walls {100 * walls:.1f} %, the human's shirt {100 * shirt:.2f} % of the picture")

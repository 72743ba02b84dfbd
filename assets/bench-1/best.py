"""Brings best.csv up to date with the results of every world; of equal results, the one that was known stays:

    cocarry bench bench-1 *.csv --worlds -o worlds.csv
    python best.py worlds.csv
"""

import csv
import sys
from pathlib import Path

KNOWN = Path(__file__).with_name("best.csv")
best = {}
for name in (KNOWN, sys.argv[1]):
    with open(name, encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            key, result = (row["set"], row["world"]), float(row["result_per_km"])
            if result > best.get(key, ("", 0.0))[1]:
                best[key] = (row["policy"], result)
lines = ["set,world,policy,result_per_km", *(f"{of},{world},{policy},{result}" for (of, world), (policy, result) in best.items())]
KNOWN.write_text("".join(line + "\n" for line in lines), encoding="utf-8")

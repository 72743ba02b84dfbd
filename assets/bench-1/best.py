"""Writes best.csv anew from the results of every world:

    cocarry bench bench-1 *.csv --worlds -o worlds.csv
    python best.py worlds.csv > best.csv
"""

import csv
import sys

best = {}
with open(sys.argv[1], encoding="utf-8", newline="") as file:
    for row in csv.DictReader(file):
        key, result = (row["set"], row["world"]), float(row["result_per_km"])
        if result > best.get(key, ("", 0.0))[1]:
            best[key] = (row["policy"], result)
print("set,world,policy,result_per_km")
for (of, world), (policy, result) in best.items():
    print(f"{of},{world},{policy},{result}")

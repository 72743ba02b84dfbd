"""A custom policy against the built-in ones: the same humans, paired differences, a picture.

It keeps its option until the human is half stubborn, then takes the one that humans are expected to like.
"""

import argparse

import cocarry


class Patient(cocarry.Policy):
    version = "1.0"

    def __init__(self, threshold=0.5):
        self.threshold, self.name = threshold, f"patient({threshold})"

    def decide(self, view):
        if view.mode == "human-led":
            return None
        if view.stubbornness < self.threshold:
            return int(view.objective_cost_m.argmin()) if view.executed is None else view.executed
        return int(view.expected_subjective_cost.argmin())


arguments = argparse.ArgumentParser(description=__doc__)
arguments.add_argument("--seeds", type=int, default=100)
arguments.add_argument("--out", help="a new picture (.svg) of the differences")
given = arguments.parse_args()

study = {"worlds": ["environment-1", "environment-4"], "plants": "point", "eta": [5, 10.5], "seeds": given.seeds}
rows = cocarry.sweep(study, policy=[Patient(0.3), Patient(0.7), "mutual"])
for quantity in ("accumulated_objective_cost_m", "accumulated_subjective_cost"):
    print(quantity)
    found = cocarry.compare(rows, quantities=quantity)
    for i in range(len(found)):
        names = f"{found['first'][i]} - {found['second'][i]}"
        print(
            f"  {found['world'][i]} eta {found['eta'][i]:4}: {names:27} {found['difference'][i]:8.2f}"
            f" ({found['difference_low'][i]:.2f} to {found['difference_high'][i]:.2f}), n {found['pairs'][i]},"
            f" d {found['effect_size'][i]:.2f}, p {found['p_holm'][i]:.2g}"
        )
if given.out:
    cocarry.plot(rows, kind="differences").save(given.out)

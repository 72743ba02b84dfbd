"""A custom human, who takes the lead only where the executed option costs over a tenth more than the best."""

import cocarry


class Tolerant(cocarry.Human):
    def decide(self, view):
        cost = view.subjective_cost(0.747, 0.765)
        current = view.executed
        close = current is not None and cost[current] <= 1.1 * cost.min()
        return cocarry.HumanDecision(current if close else int(cost.argmin()), perception=(0.747, 0.765))


for eta in (5, 10.5, 15):
    scenario = cocarry.Scenario("environment-4", plant="point", alpha=0.747, gamma=0.765, eta=eta)
    for name, human in (("paper", None), ("tolerant", Tolerant)):
        summary = cocarry.Episode(scenario, human=human).run()
        cost = summary["accumulated_objective_cost_m"] + summary["accumulated_subjective_cost"]
        print(f"eta {eta:4}: {name:9} {summary['outcome']} in {summary['steps']} steps, J + J^ {cost:.0f}")

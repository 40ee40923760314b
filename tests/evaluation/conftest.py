"""One small comparison that the tests of tables, files, pictures and page share."""

import pytest

import drillrig_env
from baselines import Constant, JumpEase
from drillrig_env.evaluation.contest import Contestant, config_of, run_contest
from drillrig_env.evaluation.histories import Histories
from drillrig_env.evaluation.provenance import provenance
from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.suites import suite
from drillrig_env.evaluation.tables import all_estimates

RIGS = 24


def contestants(env="DrillRig-v0"):
    arguments = drillrig_env.ENVIRONMENTS[env]
    makers = {
        "constant": {"": lambda suite: Constant(arguments["sensors"], slew_limit=suite.slew_limit)},
        "privileged": {"": lambda suite: JumpEase(arguments["sensors"], slew_limit=suite.slew_limit)},
        "seeds": {
            seed: lambda suite, beyond=beyond: JumpEase(
                arguments["sensors"], slew_limit=suite.slew_limit, beyond=beyond
            )
            for seed, beyond in (("0", 0.05), ("1", 0.3), ("2", 0.6))
        },
    }
    return [
        Contestant(name, members, arguments, () if name == "constant" else JumpEase.privileged)
        for name, members in makers.items()
    ]


def compare(suites, env="DrillRig-v0", folder=None):
    field, histories = contestants(env), Histories()
    config = config_of(env, suites, field, drillrig_env.__version__, "python eval.py", "constant")
    results = Results(config, provenance())
    for one in suites:
        assert run_contest(one, field, results, histories, folder) == []
    results.estimates = all_estimates(results.scores, "constant")
    return results, histories


@pytest.fixture(scope="package")
def comparison():
    """Results and histories of three policies, one of them with three seeds, in three suites."""
    return compare([suite(name, RIGS) for name in ("default", "load", "degraded")])

"""An evaluation in pieces: the same numbers in any order, kept as they come, and no more of them held than needed."""

from dataclasses import replace

import numpy as np
import pytest

from baselines import JumpEase
from drillrig_env.engine import Local
from drillrig_env.engine.packing import packed, unpacked
from drillrig_env.evaluation import contest, histories, pieces, scores
from drillrig_env.evaluation.contest import Contestant, config_of, run_contest
from drillrig_env.evaluation.evaluate import evaluate
from drillrig_env.evaluation.histories import Histories
from drillrig_env.evaluation.pieces import file_name, pieces_of
from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.store import holds_results, read, read_histories, save
from drillrig_env.evaluation.suites import PIECE, suite
from drillrig_env.evaluation.tables import all_estimates
from tests.evaluation.conftest import contestants as usual

SUITE = replace(suite("default", 11), piece=4, env={"duration": 20.0})


@pytest.fixture(autouse=True)
def _folds_that_take_no_time(monkeypatch):
    """What is found once a piece, and takes most of its time where that is small."""
    monkeypatch.setattr(scores, "folds", lambda rig, friction: np.full(np.shape(friction.normal_force), 3.0))


class Moves:
    """A quick policy: the speed reference goes up by the first that is seen."""

    def __init__(self, gain):
        self.gain = gain

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.clip(self.gain * observation[:, :1], -1.0, 1.0).astype(np.float32), None


def contestants():
    """Three policies, one of them with three seeds."""
    constant = usual()[0]
    seeds = {str(seed): lambda suite, seed=seed: Moves(0.01 * seed) for seed in range(3)}
    return [
        constant,
        Contestant("privileged", {"": lambda suite: Moves(-0.02)}, constant.env),
        Contestant("seeds", seeds, constant.env),
    ]


class Backwards(Local):
    """As another machine would: pieces are packed, and done in the opposite order. It counts them."""

    here = False

    def __init__(self):
        super().__init__()
        self.here, self.done = False, []  # pieces

    def outcomes(self, work, pieces, *, apart=False, meanwhile=None):
        content = packed(work)
        for number, piece in reversed(list(enumerate(pieces))):
            self.done.append(piece)
            outcome = next(iter(Local().outcomes(unpacked(content), [unpacked(packed(piece))])))
            yield replace(outcome, number=number)


def held(field, folder=None, engine=None, one=SUITE, progress=None):
    config = config_of("DrillRig-v0", [one], field, "0", "eval", "constant")
    results, kept = Results(config), Histories()
    failures = run_contest(one, field, results, kept, folder, progress, engine)
    return results, kept, failures


def test_a_part_of_a_suite_is_played_as_within_all_of_it():
    for whole in (suite("load", 9), suite("chapter"), replace(suite("unknown", 2))):
        make = lambda: JumpEase("state", slew_limit=whole.slew_limit)  # noqa: E731, B023
        all_of_it = run(make(), whole, duration=20.0)
        first, count = whole.rigs // 2 - 1, 4
        part = run(make(), whole.part(first, count), duration=20.0)
        assert part.speed_target.tobytes() == all_of_it.speed_target[first : first + count].tobytes()
        assert part.average.tobytes() == all_of_it.average[first : first + count].tobytes()


def test_pieces_cover_every_rig_of_every_seed_once():
    found = pieces_of(SUITE, contestants()[2], 2)
    assert [(one.seed, one.first, one.count) for one in found[:3]] == [("0", 0, 4), ("0", 4, 4), ("0", 8, 3)]
    assert len(found) == 9
    assert suite("default", PIECE + 1).definition()["piece"] == PIECE
    assert "piece" not in suite("default", PIECE).definition()


def test_pieces_in_another_order_elsewhere_give_the_same_results():
    shown = []
    alone, alone_kept, _ = held(contestants())
    other, other_kept, failures = held(contestants(), engine=Backwards(), progress=lambda *told: shown.append(told))
    assert failures == []
    assert other.rows == alone.rows
    assert other_kept.packed() == alone_kept.packed()
    assert shown[0] == ("constant", 0, 3)
    assert ("seeds", 9, 9) in shown


def test_pieces_that_are_done_are_kept_and_not_done_again(tmp_path):
    class Stops(Local):
        def outcomes(self, work, pieces, **_):
            for outcome in super().outcomes(work, pieces):
                yield outcome
                if outcome.number == 4:
                    raise KeyboardInterrupt

    whole, _, _ = held(contestants(), tmp_path / "whole")
    folder = tmp_path / "cut"
    with pytest.raises(KeyboardInterrupt):
        held(contestants(), folder, Stops())
    assert holds_results(folder)
    left = sorted(path.name for path in folder.rglob("*.npz") if path.parent.name == "privileged")
    assert left == ["only_0.npz", "only_4.npz"]
    (folder / "pieces" / "default" / "privileged" / "only_0.npz").write_bytes(b"cut")
    results, kept, engine = read(folder), read_histories(folder), Backwards()
    run_contest(SUITE, contestants(), results, kept, folder, engine=engine)
    assert [(one.contestant, one.first) for one in engine.done if one.seed == ""] == [(0, 8), (0, 0)]
    assert results.rows == whole.rows
    assert kept.packed() == read_histories(tmp_path / "whole").packed()
    assert not (folder / "pieces").exists()


class Fails:
    """A policy that fails in the second piece, on its second rig."""

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        actions = np.zeros((len(observation), 1), np.float32)
        seen = np.array(state[0]) if state else np.asarray(observation[:, 0])
        if abs(float(seen[1]) - Fails.seen) < 1e-12:
            actions[1] = np.nan
        return actions, (seen,)


def test_a_failure_names_policy_rig_and_seed_and_ends_its_policy():
    firsts = []

    class Notes:
        def predict(self, observation, state=None, episode_start=None, deterministic=True):
            if state is None:
                firsts.append(np.array(observation[:, 0]))
            return np.zeros((len(observation), 1), np.float32), (observation[:, 0],)

    env = contestants()[0].env
    held([Contestant("notes", {"": lambda suite: Notes()}, env)])
    Fails.seen = float(firsts[1][1])
    field = [Contestant("fails", {"": lambda suite: Fails()}, env), contestants()[0]]
    results, _, failures = held(field)
    assert [str(one) for one in failures] == [
        f"fails failed in default: ValueError: Fails: the action for rig 5 (seed {SUITE.first_seed + 5}) in control "
        "step 1 is not finite"
    ]
    assert results.policies == ["constant"]


def test_a_policy_that_failed_is_given_no_more_pieces():
    made = []

    def make(_suite):
        made.append(1)
        raise RuntimeError("never")

    _, _, failures = held([Contestant("never", {"": make}, contestants()[0].env)])
    assert len(failures) == len(made) == 1


def test_file_names_of_policies_are_their_own():
    assert file_name("jump_ease") == "jump_ease"
    assert file_name("runs/a") != file_name("runs_a") == "runs_a"


@pytest.fixture
def large(monkeypatch):
    """More than 10 rigs are many."""
    for room in (contest, pieces, histories):
        monkeypatch.setattr(room, "LARGE", 10)
    monkeypatch.setattr(histories, "PIECE", SUITE.piece)
    pytest.importorskip("pyarrow")


@pytest.mark.slow
def test_a_large_suite_is_kept_in_parquet_files_with_the_same_tables(large, tmp_path):
    small, _, _ = held(contestants())
    results, kept, _ = held(contestants(), tmp_path, Backwards())
    results.estimates = all_estimates(results.scores, "constant")
    save(tmp_path, results, kept)
    assert not (tmp_path / "pieces").exists()
    assert results.rows == ""
    again = read(tmp_path)
    for policy in ("constant", "privileged", "seeds"):
        for name, column in small.scores["default"][policy].items():
            stored = again.scores["default"][policy][name]
            if column.dtype.kind == "f":
                np.testing.assert_allclose(stored, column, rtol=1e-5)
            else:
                assert stored.tolist() == column.tolist()
    again.estimates = {}
    assert all_estimates(again.scores, "constant") == results.estimates
    assert {region for _, _, region in kept.kept} <= {"below", "bistable"}
    stamps = [one.stamp for one in again.stored["default"].values()]
    assert [one["rows"] for one in stamps] == [11, 11, 33]
    other, _, _ = held(contestants(), tmp_path / "other")
    assert [one.stamp["digest"] for one in other.stored["default"].values()] == [one["digest"] for one in stamps]


def test_a_damaged_file_of_rows_is_refused(large, tmp_path):
    held(contestants()[:1], tmp_path)
    path = tmp_path / "rows" / "default" / "constant.parquet"
    content = path.read_bytes()
    path.write_bytes(content[:-9] + b"x" + content[-8:])
    with pytest.raises(ValueError, match=r"constant\.parquet is damaged: it is not what was written"):
        read(tmp_path)
    path.unlink()
    with pytest.raises(ValueError, match=r"constant\.parquet is missing"):
        read(tmp_path)


def test_evaluation_in_python(tmp_path):
    engine = Backwards()
    results = evaluate(["constant", JumpEase], ["default"], rigs=6, engine=engine, folder=tmp_path)
    assert results.policies == ["constant", "JumpEase"]
    assert len(engine.done) == 2
    assert read(tmp_path).rows == results.rows
    assert evaluate(["constant"], rigs=6).rows == "".join(results.rows.splitlines(keepends=True)[:7])
    with pytest.raises(ValueError, match="rigs = 20000 is not allowed; allowed: <= 10000 without a folder"):
        evaluate(["constant"], rigs=20_000)

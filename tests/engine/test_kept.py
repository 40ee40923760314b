"""Pieces that are kept in a folder, and gone on with after a stop."""

import numpy as np
import pytest

from drillrig_env.engine import Local
from drillrig_env.engine.kept import each_kept


def doubled(piece):
    return {"twice": np.array([2.0 * piece]), "name": np.array(["a", "b"])}


def found(folder, work=doubled, pieces=range(5), of="doubles"):
    return {number: one["twice"][0] for number, one in each_kept(Local(), work, list(pieces), folder, of)}


def test_what_is_done_is_not_done_again(tmp_path):
    asked = []

    def stopped(piece):
        if piece == 3:
            raise KeyboardInterrupt
        return doubled(piece)

    def noted(piece):
        asked.append(piece)
        return doubled(piece)

    with pytest.raises(KeyboardInterrupt):
        found(tmp_path, stopped)
    (tmp_path / "piece_1.npz").write_bytes(b"cut")
    assert found(tmp_path, noted) == {number: 2.0 * number for number in range(5)}
    assert asked == [1, 3, 4]


def test_without_a_folder_nothing_is_kept():
    assert found(None) == {number: 2.0 * number for number in range(5)}


def test_a_folder_of_other_work_is_refused(tmp_path):
    found(tmp_path)
    for changes in ({"of": "triples"}, {"pieces": range(6)}):
        with pytest.raises(ValueError, match="holds pieces of other work; remove it, or name another folder"):
            found(tmp_path, **changes)

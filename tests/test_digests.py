"""The numbers stay the same: bit for bit on machines that have a record, to six digits elsewhere."""

import json

import pytest

from tests.digests import KINDS, RECORD, digest_of, machine

KEPT = json.loads(RECORD.read_text(encoding="utf-8"))


@pytest.mark.parametrize("kind", KINDS)
def test_numbers_are_what_they_were(kind):
    found = digest_of(kind)
    for kept in KEPT.values():
        assert found["values"] == pytest.approx(kept[kind]["values"], rel=1e-5, abs=1e-9)
    if machine() in KEPT:
        assert found["digest"] == KEPT[machine()][kind]["digest"]

"""Instruments fail as they are told, and only then."""

import pytest

from drillrig_env.twin.faults import Fault, FaultyInstruments


def shown(kind, channel="current"):
    """What an instrument shows that fails from 2 s to 4 s, of what is the time each 0.1 s."""
    fault = Fault.parse(f"{channel}:{kind}:2:4")
    instruments = FaultyInstruments([fault], ("current", "bit_speed"), 0.1)
    return [instruments.show({"current": 0.1 * k, "bit_speed": [0.1 * k - 0.05, 0.1 * k]}, 0.1 * k) for k in range(60)]


def test_they_fail_and_recover():
    for kind in ("missing", "frozen", "wild", "slow", "drifting"):
        found = shown(kind)
        for k in (*range(20), *range(40, 60)):
            assert found[k] == ({"current": 0.1 * k, "bit_speed": [0.1 * k - 0.05, 0.1 * k]}, {})
        assert all(values["bit_speed"][1] == pytest.approx(0.1 * k) for k, (values, _) in enumerate(found))
    assert "current" not in shown("missing")[30][0]
    assert [values["current"] for values, _ in shown("frozen")[20:40]] == [2.0] * 20
    assert shown("wild")[30][0]["current"] == pytest.approx(3001.0)
    assert shown("drifting")[30][0]["current"] == pytest.approx(3.0 * 1.05)
    values, ages = shown("slow")[30]
    assert values["current"] == pytest.approx(2.5)
    assert ages == {"current": pytest.approx(0.5)}


def test_of_several_samples_all_fail():
    assert shown("wild", "bit_speed")[30][0]["bit_speed"] == pytest.approx([2951.0, 3001.0])
    assert shown("frozen", "bit_speed")[30][0]["bit_speed"] == pytest.approx([1.95, 2.0])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("current:frozen", "allowed: channel:kind:from:to"),
        ("current:melting:1:2", "kind 'melting' is not known; allowed: missing"),
        ("current:frozn:1:2", "did you mean frozen"),
        ("current:frozen:2:1", "allowed: from < to"),
        ("current:frozen:a:1", "two numbers >= 0"),
        ("current:frozen:nan:1", "two numbers >= 0"),
    ],
)
def test_what_is_no_fault_is_named(text, message):
    with pytest.raises(ValueError, match=message):
        Fault.parse(text)


def test_a_channel_that_is_not_there_is_named():
    with pytest.raises(ValueError, match=r"unknown channel 'curent'; did you mean current\?"):
        FaultyInstruments([Fault.parse("curent:frozen:1:2")], ("current",), 0.1)

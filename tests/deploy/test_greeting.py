"""A greeting that is none is an error before anything stands on it."""

import math

import pytest

from drillrig_env.deploy.greeting import Greeting

SAID = {
    "channels": {"top_speed": "rad/s"},
    "period": 0.1,
    "speed": 1,
    "waits": False,
    "time": 12.3,
    "reference": 2.0,
    "target": 3,
}


def test_what_is_said_is_read():
    found = Greeting.of({**SAID, "drive": {"k_p": 3.0}, "more": 1})
    assert (found.channels, found.period, found.target, found.waits) == ({"top_speed": "rad/s"}, 0.1, 3.0, False)
    assert not Greeting.of({name: value for name, value in SAID.items() if name != "waits"}).waits


@pytest.mark.parametrize(
    "wrong",
    [{"period": 0.0}, {"speed": -1.0}, {"time": math.nan}, {"target": None}, {"channels": 3}, {"channels": ["top"]},
     {"drive": [1.0]}, {"parameters": "none"}, {"reference": "fast"}],
)  # fmt: skip
def test_what_is_no_greeting_is_an_error(wrong):
    with pytest.raises((TypeError, ValueError)):
        Greeting.of({**SAID, **wrong})


@pytest.mark.parametrize("name", [name for name in SAID if name != "waits"])
def test_what_is_missing_is_an_error(name):
    with pytest.raises(KeyError):
        Greeting.of({one: value for one, value in SAID.items() if one != name})

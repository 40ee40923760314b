"""The benchmark of rewards of one's own: what it compares, and its table."""

from benchmarks.own_reward import main, microseconds, rewards


def test_it_compares_one_reward_with_what_is_added_to_it():
    compared = rewards()
    assert [reward.own is None for reward in compared.values()] == [True, False, False]
    assert [reward.own.compiled for reward in compared.values() if reward.own] == [True, False]


def test_every_reward_is_timed_on_every_number_of_copies():
    found = microseconds((1, 3), 1)
    assert list(found) == [1, 3]
    assert all(time > 0.0 for times in found.values() for time in times.values())


def test_command_prints_the_table(capsys):
    assert main(["--sizes", "2", "--repeats", "1"]) in (None, 0)
    printed = capsys.readouterr().out
    assert "| 2 | default |" in printed
    assert "| 2 | terms in Python |" in printed

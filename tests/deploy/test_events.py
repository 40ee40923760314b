"""Events are kept in turn, and in a file at once."""

from drillrig_env.deploy import Events


def test_events_are_kept_and_written_line_by_line(tmp_path):
    events = Events(tmp_path / "events.txt")
    events.add(0.0, "normal", "start", "from 2 to 3 rad/s")
    events.add(1.25, "hold", "fault", "current missing")
    assert (tmp_path / "events.txt").read_text().splitlines() == [str(event) for event in events.kept]
    assert str(events.kept[1]) == "1.250 s, hold: fault: current missing"
    assert [event.reason for event in events.of("fault")] == ["current missing"]


def test_events_that_cannot_be_written_are_kept(tmp_path):
    events = Events(tmp_path)  # a folder
    events.add(0.0, "normal", "start", "from 2 to 3 rad/s")
    assert len(events.kept) == 1

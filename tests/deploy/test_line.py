"""Lines are JSON objects, whole, and not too long."""

import math

import pytest

from drillrig_env.deploy.line import LONGEST, BadLine, Lines, decode, encode


def test_a_message_comes_back_to_the_last_bit():
    message = {"values": {"top_speed": 0.1 + 0.2, "current": None}, "taken": 3}
    line = encode(message)
    assert line.endswith(b"\n")
    assert b"\n" not in line[:-1]
    assert decode(line) == message


def test_lines_are_cut_wherever_the_stream_is():
    content = b"".join(encode({"k": k}) for k in range(50)) + b'{"half'
    for size in (1, 7, 1000):
        lines, found = Lines(), []
        for at in range(0, len(content), size):
            found += [decode(line)["k"] for line in lines.take(content[at : at + size])]
        assert found == list(range(50))
        assert [decode(line) for line in lines.take(b'": 1}\n\n  \n')] == [{"half": 1}]


def test_a_line_that_is_too_long_is_refused():
    assert list(Lines().take(b"x" * LONGEST)) == []
    with pytest.raises(BadLine, match=f"more than {LONGEST} bytes"):
        list(Lines().take(b"x" * (LONGEST + 1)))
    with pytest.raises(BadLine, match=f"more than {LONGEST} bytes"):
        list(Lines().take(b"x" * (LONGEST + 1) + b"\n"))


@pytest.mark.parametrize("line", [b"", b"stop", b'"text"', b"[1]", b"\xff\xfe", b'{"a": 1', b"[" * 9999])
def test_what_is_no_message_is_named(line):
    with pytest.raises(BadLine, match=r"is no JSON|allowed: a JSON object"):
        decode(line)


def test_no_number_leaves_that_is_none():
    with pytest.raises(ValueError, match="JSON"):
        encode({"command": math.nan})

"""A token is the first line of a file, and long enough."""

import pytest

from drillrig_env.deploy.token import read_token


def test_the_first_line_is_the_token(tmp_path):
    (tmp_path / "token").write_text("  0123456789abcdef \nmore\n")
    assert read_token(tmp_path / "token") == "0123456789abcdef"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "length of the first line = 0 characters is not allowed; allowed: 16 to 1024"),
        (b"0123456789abcde\n", "= 15 characters"),
        (b"x" * 1025, "= 1025 characters"),
        (b"\xff\xfe" * 20, "is no file that can be read"),
    ],
)
def test_what_is_no_token_is_named(tmp_path, content, message):
    (tmp_path / "token").write_bytes(content)
    with pytest.raises(ValueError, match=message):
        read_token(tmp_path / "token")

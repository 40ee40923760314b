"""Tables and lists of all pages: columns of words and of numbers, and entries that would break a table."""

from drillrig_env.markdown import listed, sentence, table


def test_first_columns_are_words_and_the_others_numbers():
    assert table(["a", "b", "c"], [[1, 2, 3]]).splitlines() == ["| a | b | c |", "|---|---:|---:|", "| 1 | 2 | 3 |"]
    assert table(["a", "b"], [], words=2).splitlines()[1] == "|---|---|"
    assert table(["a", "b", "c"], [], words={"a", "c"}).splitlines()[1] == "|---|---:|---|"


def test_an_entry_ends_neither_its_cell_nor_its_line():
    text = table(["", "speed"], [["|ω| <\n 3", ""]])
    assert text.splitlines() == ["| | speed |", "|---|---:|", "| \\|ω\\| < 3 | |"]


def test_lists_have_a_word_before_the_last():
    assert [listed(range(1, count)) for count in (2, 3, 4)] == ["1", "1 and 2", "1, 2 and 3"]
    assert listed(["a", "b"], "or") == "a or b"


def test_a_caption_becomes_a_sentence():
    assert sentence("cost: mean of - reward") == "Cost: mean of - reward."

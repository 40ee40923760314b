"""The table of README.md and of the site's first page: what the stored results hold, and nothing else."""

from pathlib import Path

import pytest

from docs.make.__main__ import main
from docs.make.readme import COMMAND, scores, texts
from docs.make.results import stored_results

ROOT = Path(__file__).parents[2]


def test_the_projects_tables_are_up_to_date():
    made = texts(ROOT / "docs")
    assert [path.name for path in made] == ["README.md", "index.md"]
    for path, written in made.items():
        assert path.read_text(encoding="utf-8") == written, f"out of date; run: {COMMAND}"


@pytest.mark.slow
def test_it_has_the_numbers_of_the_results_to_their_digits():
    results = stored_results(ROOT / "docs")["DrillRig-v0"]
    lines = [line for line in scores(results).splitlines() if line.startswith("| `")]
    assert len(lines) == 7
    for line in lines:
        policy, _, mitigated, below, late, seconds = (part.strip() for part in line.strip("| ").split(" | "))
        found = {name: suite[policy.strip("`")]["main"] for name, suite in results.estimates.items()}
        for shown, suite, heading in (
            (mitigated, "default", "mitigated"),
            (below, "default", "below ω_c"),
            (late, "degraded", "mitigated"),
            (seconds, "default", "to calm"),
        ):
            assert float(shown.split()[0]) == pytest.approx(found[suite][heading]["value"], abs=0.051)


def test_a_readme_without_a_place_for_it_is_refused(tmp_path, capsys):
    (tmp_path / "README.md").write_text("# DrillRig\n")
    (tmp_path / "docs").mkdir()
    with pytest.raises(SystemExit) as end:
        main(["readme", "--docs", str(tmp_path / "docs")])
    assert end.value.code == 2
    assert "has no place for its table" in capsys.readouterr().err

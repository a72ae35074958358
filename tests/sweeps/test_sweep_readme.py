"""The sweep of the guide is run as it says."""

import re
import tomllib

from click.testing import CliRunner
from helpers import guide

from fab.cli.group import main
from fab.sweeps.search import Goals
from fab.sweeps.search_settings import SearchSettings


def test_the_sweep_of_the_guide_does_what_it_says(here, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    part = guide("sweeps")
    toml, search = re.findall(r"```toml\n(.*?)```", part, re.DOTALL)
    small = toml.replace("steps = 5", "steps = 2").replace("[6, 8, 10]", "[6]")
    small = small.replace("count = 3", "count = 2")
    (tmp_path / "angles.toml").write_text(small)
    (block,) = re.findall(r"```sh\n(.*?)```", part, re.DOTALL)
    for line in block.splitlines():
        words = [word.strip('"') for word in re.findall(r'"[^"]*"|\S+', line.partition("#")[0])]
        result = CliRunner().invoke(main, words[1:])
        assert result.exit_code == 0, result.output
    table = tomllib.loads(search)["search"]
    assert SearchSettings(**table).trials == 200
    assert Goals.of(SearchSettings(**table)).columns == ("sheets.minutes",)
    lines = result.stdout.splitlines()
    assert "simulation.peak_strain" in lines[0]
    assert "solids.clearance_min_mm" in lines[0]
    assert re.fullmatch(r"\d rows? of \d", lines[-1])

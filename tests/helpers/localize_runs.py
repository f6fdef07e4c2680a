"""``brickpose localize`` on a bag of the office."""

import json

from laser_office import write_map

from app.command_line import main
from app.features.lab.trajectories.reading import parse_tum


def run(folder, bag, *options):
    out = folder / "out"
    code = main(
        ["localize", str(bag), "--map", str(write_map(folder)), "--out", str(out), *options]
    )
    assert code == 0
    way = parse_tum((out / "localized.tum").read_text(), "localized.tum")
    return json.loads((out / "results.json").read_text()), way

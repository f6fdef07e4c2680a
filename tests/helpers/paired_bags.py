"""What is read of a bag, scan by scan."""

from app.features.lab.localize.reading.bag import Bag
from app.features.lab.localize.reading.layout import choose, find_layout
from app.features.lab.localize.reading.pairing import Pairing


def paired(path, clock="header"):
    """The measurements of a bag, what is left out, and what is remarked."""
    with Bag(path) as bag:
        chosen = choose(bag)
        pairing = Pairing(bag, chosen, find_layout(bag, chosen, None), clock)
        return list(pairing.measurements()), pairing.left_out, pairing.remarks

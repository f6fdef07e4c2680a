"""Messages with anything in them, by the definitions of their types."""

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from app.features.ros.message_types import message_class
from app.features.ros.rosbridge.names import FILLER, NUMBERS, fields
from app.features.ros.topics import TOPICS

TEXTS = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=5)


def topic(name):
    return next(item for item in TOPICS if item.name == name)


def messages(type_name: str, finite: bool = True):
    """Any message of a type; arrays are short."""
    known = {name: _values(kind, finite) for name, kind in fields(type_name).items()}
    made = message_class(type_name)
    return st.fixed_dictionaries(known).map(lambda read: made(**(read or {FILLER: 0})))


def _values(kind, finite):
    lengths = st.just(kind.length) if kind.length else st.integers(0, 3)
    if kind.nested or kind.name not in NUMBERS:
        one = messages(kind.name, finite) if kind.nested else TEXTS
        listed = lengths.flatmap(lambda n: st.lists(one, min_size=n, max_size=n))
        return listed if kind.many else one
    dtype = NUMBERS[kind.name]
    numbers = arrays.from_dtype(dtype, allow_nan=not finite, allow_infinity=not finite)
    if kind.many:
        return lengths.flatmap(lambda n: arrays.arrays(dtype, n, elements=numbers))
    return numbers.map(lambda number: np.asarray(number).item())

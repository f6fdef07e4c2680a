"""Fields that a generator draws, by names such as ``generated-17``."""

from __future__ import annotations

from robot.fields.field import Field
from robot.fields.generator.names import MAX_SEED, PREFIX, generated_seed
from robot.fields.svg_field import field_of_drawing
from robot.hooks import FieldSource


def is_generated(name: str) -> bool:
    """Return whether a name is that of a generated field."""
    return generated_seed(name) is not None


def generated_field(name: str) -> Field:
    """Return the field of a seed, as ``generated-17``."""
    from robot.fields.generator.generated import drawing  # noqa: PLC0415 - few fields are

    seed = generated_seed(name)
    assert seed is not None
    field = field_of_drawing(drawing(seed), name)
    field.require_free()
    return field


FIELDS = (
    FieldSource(
        f"{PREFIX}0 to {PREFIX}{MAX_SEED}", is_generated, generated_field, (f"{PREFIX}17",)
    ),
)
"""What ``load_field`` makes by these names."""

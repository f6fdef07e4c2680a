"""Every route of the server, asked for what its own description allows and forbids."""

import pytest
import schemathesis
from hypothesis import HealthCheck, given, settings
from schemathesis.generation import GenerationMode

pytestmark = pytest.mark.slow

ENDLESS = "/camera.mjpg"
"""Its answer never ends; another test reads it."""
NUMBERED = "/api/ray/{ray}"
"""A route that can be asked wrongly; a name may be any text, and most others take nothing."""
ASKED_WRONGLY = (NUMBERED, "/api/pose_fit", "/api/likelihood", "/api/likelihood/headings")
EXAMPLES = 15
QUICK = settings(max_examples=EXAMPLES, suppress_health_check=list(HealthCheck))


def test_each_answer_is_as_described_and_no_request_is_a_defect(server):
    """Schemathesis checks status, media type, headers and content, and what must be refused."""
    schema = schemathesis.openapi.from_url(f"{server.url}/openapi.json")
    operations = [found.ok() for found in schema.get_all_operations()]
    asked = {operation.path for operation in operations}
    assert {"/api/state", *ASKED_WRONGLY, "/api/recordings/{name}", ENDLESS} <= asked
    for operation in operations:
        if operation.path != ENDLESS:
            ask(operation, GenerationMode.POSITIVE)
        if operation.path in ASKED_WRONGLY:
            ask(operation, GenerationMode.NEGATIVE)


def ask(operation, mode):
    @QUICK
    @given(case=operation.as_strategy(generation_mode=mode))
    def answered(case):
        case.call_and_validate(timeout=20)

    answered()

"""The filter's parameters by rosapi, as roslibjs asks for them."""

from __future__ import annotations

import json
import re

import pytest
from engine_runs import run
from rosbridge_sessions import bridge_of

from app.engine.drivers import Driver
from app.features.ros.rosbridge.session import RosbridgeSession
from app.messages.commands import SetParametersCommand

NAMES = ["/brickpose:alpha1", "brickpose:alpha1", "/brickpose/alpha1", "/alpha1", "alpha1"]


@pytest.mark.parametrize("name", NAMES)
def test_a_parameter_is_got_set_and_got(program, client, name):
    (before,) = run(program, 0.02)
    result, values = client.call("/rosapi/get_param", {"name": name})
    assert result and json.loads(values["value"]) == before.filter.parameters.motion.alpha1
    asked = {"name": name, "value": json.dumps(0.31)}
    assert client.call("/rosapi/set_param", asked) == (True, {"successful": True, "reason": ""})
    after = run(program, 0.02)[-1]
    assert SetParametersCommand in map(type, after.commands)
    assert after.filter.parameters.motion.alpha1 == 0.31
    assert client.call("rosapi/get_param", [name])[1]["value"] == "0.31"


def test_the_names_are_listed_and_asked_for(client):
    names = client.call("/rosapi/get_param_names")[1]["names"]
    assert {"/brickpose:alpha1", "/brickpose:max_particles"} <= set(names)
    assert names == sorted(names)
    assert client.call("/rosapi/has_param", {"name": "alpha1"})[1] == {"exists": True}
    assert client.call("/rosapi/has_param", {"name": "beta"})[1] == {"exists": False}
    assert client.call("/rosapi/has_param", {"name": "/other:alpha1"})[1] == {"exists": False}
    found = client.call("/rosapi/search_param", {"name": "alpha1"})[1]
    assert found == {"global_name": "/brickpose:alpha1"}
    services = client.call("/rosapi/services")[1]["services"]
    assert {"/rosapi/get_param", "/rosapi/set_param"} <= set(services)


@pytest.mark.parametrize("value", ['"beam"', "beam"])
def test_a_word_is_set(program, client, value):
    run(program, 0.02)
    asked = {"name": "laser_model_type", "value": value}
    assert client.call("/rosapi/set_param", asked)[0]
    assert run(program, 0.02)[-1].filter.parameters.sensor.laser_model_type == "beam"


@pytest.mark.parametrize(
    ("service", "args", "words"),
    [
        ("get_param", {"name": "beta"}, "beta is no parameter; valid are .*/brickpose:alpha1"),
        ("get_param", {"name": 1}, "name is 1; valid is a text"),
        ("get_param", {}, "name is None; valid is a text"),
        ("set_param", {"name": "beta", "value": "1"}, "beta is no parameter"),
        ("set_param", {"name": "alpha1", "value": "-3"}, "alpha1"),
        ("set_param", {"name": "alpha1", "value": "[1, 2]"}, "alpha1 is '.1, 2.'"),
        ("set_param", {"name": "alpha1"}, "alpha1 is None"),
        ("set_param", {"name": "alpha1", "value": '"wide"'}, "alpha1"),
        ("set_param", {"name": "alpha1", "value": "NaN"}, "alpha1|finite"),
        ("set_param", "alpha1", "name is None"),
        (
            "set_param",
            {"name": "laser_model_type", "value": "/tmp/evil.py:Model"},
            "the page alone chooses files of Python",
        ),
    ],
)
def test_what_is_invalid_is_refused_and_nothing_changes(program, client, service, args, words):
    before = run(program, 0.02)[-1].filter.parameters
    result, values = client.call(f"/rosapi/{service}", args)
    assert result is False
    assert re.search(words, values)
    assert run(program, 0.02)[-1].filter.parameters == before


def test_an_unknown_parameter_has_the_default_that_is_given(client):
    asked = {"name": "/beta", "default_value": "5"}
    assert client.call("/rosapi/get_param", asked)[1]["value"] == "5"


def test_a_watcher_gets_and_does_not_set(program):
    run(program, 0.02)
    session = RosbridgeSession(
        bridge_of(program), lambda: None, Driver.numbered("rosbridge"), watches=True
    )

    def call(service: str, **args: str) -> dict[str, object]:
        asked = {"op": "call_service", "service": f"/rosapi/{service}", "args": args}
        (answer,) = session.receive(json.dumps(asked))
        result: dict[str, object] = json.loads(answer if isinstance(answer, str) else answer())
        return result

    assert call("get_param", name="alpha1")["result"] is True
    refused = call("set_param", name="alpha1", value="0.5")
    assert refused["result"] is False and "only watches" in str(refused["values"])

"""What ``brickpose check`` writes: for people, JSON, JUnit, Gradescope."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from typing import Any
from xml.etree import ElementTree

from app.features.course.grader.finding import Flaw, LessonResult
from app.languages.catalogue import Catalogue

ADDRESS = "http://127.0.0.1:8080"
"""Where ``brickpose learn`` is, if no other port was asked for."""


def for_people(results: Sequence[LessonResult], language: Catalogue) -> str:
    """Return all findings as text."""
    return "\n".join(line for result in results for line in _lines(result, language)) + "\n"


def _lines(result: LessonResult, language: Catalogue) -> Iterator[str]:
    state = language.t("passed") if result.passed else language.t("not yet")
    if not result.started:
        state = language.t("not begun")
    name = language.t(result.name)
    head = language.t("Lesson {number}, {name}:", number=result.lesson, name=name)
    yield f"{head} {state}"
    for finding in result.findings:
        yield ""
        yield f"  {finding.symptom.say(language)} [{finding.cause}]"
        for name, words in _parts(finding, language):
            yield f"    {name}: {words}"
    if result.findings:
        yield ""


def _parts(finding: Flaw, language: Catalogue) -> Iterator[tuple[str, str]]:
    yield language.t("The smallest case"), finding.case.say(language)
    yield language.t("It seems"), finding.seems.say(language)
    yield language.t("Look next"), finding.advice.say(language)
    if finding.situation:
        yield language.t("See it in the dashboard"), ADDRESS + finding.link


def as_json(results: Sequence[LessonResult], language: Catalogue) -> dict[str, Any]:
    """Return ``{"passed", "findings", "lessons"}``; lessons that were not begun do not fail."""
    findings = [item.to_json(language) for result in results for item in result.findings]
    lessons = [
        {"lesson": item.lesson, "passed": item.passed, "begun": item.started} for item in results
    ]
    begun = [item for item in results if item.started]
    passed = bool(begun) and all(item.passed for item in begun)
    return {"passed": passed, "findings": findings, "lessons": lessons}


def as_junit(results: Sequence[LessonResult], language: Catalogue) -> str:
    """Return JUnit's XML: a test case a lesson; one that was not begun is skipped."""
    return _xml(_suite("brickpose check", results, language))


def as_junit_of_class(
    files: Iterable[tuple[str, Sequence[LessonResult], str]], language: Catalogue
) -> str:
    """Return JUnit's XML of many files: a suite each.

    Args:
        files: the name of each, its results, and why it could not be graded, if it could not.
        language: of the words.
    """
    suites = ElementTree.Element("testsuites", name="brickpose check")
    for name, results, problem in files:
        suite = _suite(name, results, language)
        if problem:
            suite.set("tests", "1")
            suite.set("errors", "1")
            case = ElementTree.SubElement(suite, "testcase", classname="lessons", name="file")
            ElementTree.SubElement(case, "error", message=_readable(problem))
        suites.append(suite)
    return _xml(suites)


def _suite(name: str, results: Sequence[LessonResult], language: Catalogue) -> ElementTree.Element:
    suite = ElementTree.Element(
        "testsuite",
        name=_readable(name),
        tests=str(len(results)),
        failures=str(sum(bool(item.findings) for item in results)),
        skipped=str(sum(not item.started for item in results)),
    )
    for result in results:
        case = ElementTree.SubElement(
            suite, "testcase", classname="lessons", name=f"{result.lesson} {result.name}"
        )
        if not result.started:
            ElementTree.SubElement(case, "skipped")
        for finding in result.findings:
            symptom = finding.symptom.say(language)
            failure = ElementTree.SubElement(case, "failure", type=finding.cause, message=symptom)
            failure.text = _readable(_in_words(finding, language))
    return suite


def _xml(element: ElementTree.Element) -> str:
    return ElementTree.tostring(element, encoding="unicode", xml_declaration=True) + "\n"


def as_gradescope(results: Sequence[LessonResult], language: Catalogue) -> str:
    """Return Gradescope's ``results.json``: a point a lesson."""
    tests = [
        {
            "name": f"{result.lesson} {result.name}",
            "score": float(result.passed),
            "max_score": 1.0,
            "output": "\n\n".join(_in_words(item, language) for item in result.findings),
            "visibility": "visible",
        }
        for result in results
    ]
    return json.dumps({"tests": tests}, indent=2, ensure_ascii=False) + "\n"


def _in_words(finding: Flaw, language: Catalogue) -> str:
    parts = [f"{name}: {words}" for name, words in _parts(finding, language)]
    return "\n".join([f"{finding.symptom.say(language)} [{finding.cause}]", *parts])


def _readable(text: str) -> str:
    """Return a text without characters that XML cannot hold."""
    return "".join(char for char in text if char.isprintable() or char in "\n\t")

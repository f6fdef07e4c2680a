"""Measures the grader: ``grader_trials.py [bugs pairs correct steering mutants checks programs]``.

bugs: the 22 mistakes in three writings, 20 seeds. pairs: two of them at once. correct: ten styles.
steering: mistakes and right controllers of lesson 10, 10 seeds.
mutants: every operator, sign, index and constant of the solutions changed. checks: which cases
no mutant fails. programs: those in ``course/programs``, as students write them. times: how long.
"""

from __future__ import annotations

import ast
import copy
import sys
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress

from course import steering
from course.correct import CORRECT
from course.mistakes import WRITINGS, pairs
from course.solutions import ARRAYS, KALMAN, LOOPS, MATRICES
from course.student_programs import SETS, programs

from app.features.course.grader.case import Case
from app.features.course.grading import SEED, grade, grade_often, measure
from app.features.course.lesson import Lesson, lesson_of, lessons
from app.features.course.sandbox.student_process import StudentError, StudentProcess

SEEDS = tuple(range(1000, 1020))


def bugs(seeds: tuple[int, ...] = SEEDS) -> tuple[float, list[str]]:
    """Share of gradings that name the right cause, and what was named instead."""
    right, missed = 0, []
    for writing in WRITINGS:
        results = grade_often(writing.source, "mine.py", lesson_of(writing.lesson), seeds)
        for seed, result in zip(seeds, results, strict=True):
            named = [finding.cause for finding in result.findings]
            if writing.code in named[:1]:
                right += 1
            else:
                missed.append(f"{writing.code} in {writing.base}, seed {seed}: {named}")
    return right / (len(WRITINGS) * len(seeds)), missed


def two_bugs(seeds: tuple[int, ...] = SEEDS[:3]) -> tuple[float, list[str]]:
    """Share of gradings of two mistakes that name at least one of them."""
    right, missed, trials = 0, [], pairs()
    for first, second, number, source in trials:
        for result in grade_often(source, "mine.py", lesson_of(number), seeds):
            named = {finding.cause for finding in result.findings}
            if named & {first, second}:
                right += 1
            else:
                missed.append(f"{first} and {second}: {sorted(named)}")
    return right / (len(trials) * len(seeds)), missed


def false_alarms(seeds: tuple[int, ...] = SEEDS) -> list[str]:
    """What is said about correct solutions."""
    return [
        f"{style}, lesson {result.lesson}: {finding.cause}: {finding.case.say()}"
        for style, source in CORRECT.items()
        for lesson in lessons()
        if lesson.number <= 8
        for result in grade_often(source, f"{style}.py", lesson, seeds)
        for finding in result.findings
    ]


def steered(seeds: tuple[int, ...] = SEEDS[:10]) -> tuple[float, list[str], list[str]]:
    """Share of lesson 10's mistakes named first, those missed, what is said of right ones."""
    lesson, right, missed = lesson_of(10), 0, []
    for writing in steering.MISTAKES:
        results = grade_often(steering.source_of(writing), "mine.py", lesson, seeds)
        for seed, result in zip(seeds, results, strict=True):
            named = [finding.cause for finding in result.findings]
            right += named[:1] == [writing.code]
            if named[:1] != [writing.code]:
                missed.append(f"{writing.code} in {writing.base}, seed {seed}: {named}")
    alarms = [
        f"{style}: {finding.cause}"
        for style, source in steering.ODD.items()
        for result in grade_often(steering.HEAD + source, "mine.py", lesson, seeds)
        for finding in result.findings
    ]
    return right / (len(steering.MISTAKES) * len(seeds)), missed, alarms


OPERATORS = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Mod: ast.Mult,
    ast.FloorDiv: ast.Mult, ast.Pow: ast.Mult, ast.Lt: ast.Gt, ast.Gt: ast.Lt, ast.LtE: ast.Gt,
    ast.GtE: ast.Lt, ast.And: ast.Or, ast.Or: ast.And, ast.BitAnd: ast.BitOr,
}  # fmt: skip
NAMES = {
    "cos": "sin", "sin": "cos", "max": "min", "min": "max", "argmax": "argmin",
    "radians": "degrees", "deg2rad": "rad2deg", "left": "right", "right": "left",
    "rng": "np.random",
}  # fmt: skip


def mutants(source: str) -> Iterator[tuple[str, str, str]]:
    """Yield function, what was changed, and the changed source."""
    tree = ast.parse(source)
    for place, node in enumerate(ast.walk(tree)):
        for words, change in _changes(node):
            mutated = copy.deepcopy(tree)
            target = next(item for at, item in enumerate(ast.walk(mutated)) if at == place)
            change(target)
            function = next(
                (item.name for item in tree.body if isinstance(item, ast.FunctionDef)
                 and any(inner is node for inner in ast.walk(item))), "",
            )  # fmt: skip
            line = getattr(node, "lineno", 0)
            yield function, f"line {line}: {words}", ast.unparse(mutated)


def _changes(node: ast.AST):
    operator = getattr(node, "op", None)
    if isinstance(node, ast.BinOp | ast.BoolOp | ast.AugAssign) and type(operator) in OPERATORS:
        other = OPERATORS[type(operator)]
        yield f"{type(operator).__name__} to {other.__name__}", lambda n: setattr(n, "op", other())
    if isinstance(node, ast.Compare) and type(node.ops[0]) in OPERATORS:
        new = OPERATORS[type(node.ops[0])]
        yield f"{type(node.ops[0]).__name__}", lambda n: n.ops.__setitem__(0, new())
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        yield "sign dropped", lambda n: setattr(n, "op", ast.UAdd())
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        value = node.value
        for changed in {value + 1, value * 1.5 if isinstance(value, float) else value - 1} - {
            value
        }:
            yield f"{value} to {changed}", lambda n, v=changed: setattr(n, "value", v)
    if isinstance(node, ast.Attribute) and node.attr in NAMES:
        yield f".{node.attr}", lambda n: setattr(n, "attr", NAMES[n.attr])
    if isinstance(node, ast.Name) and node.id in NAMES and isinstance(node.ctx, ast.Load):
        yield node.id, lambda n: setattr(n, "id", NAMES[n.id])


def mutation_trial(sources: dict[str, str]) -> tuple[int, list[str]]:
    """How many mutants there were, and which nobody found."""
    number_of = {name: item for item in lessons() for name in item.checks.functions}
    work = [
        (style, function, words, changed)
        for style, source in sources.items()
        for function, words, changed in mutants(source)
        if function in number_of
    ]

    def survives(item: tuple[str, str, str, str]) -> str | None:
        style, function, words, changed = item
        result = grade(changed, "mutant.py", number_of[function])
        return f"{style} {function} {words}" if result.passed else None

    with ThreadPoolExecutor(2) as pool:
        survivors = [words for words in pool.map(survives, work) if words]
    return len(work), survivors


def idle_checks() -> list[str]:
    """Cases of the lessons that no mutant of a solution fails: they would be missed by nobody."""
    idle = []
    for lesson in lessons():
        own = [
            item
            for item in mutants(ARRAYS + KALMAN + steering.ARRAYS)
            if item[0] in lesson.checks.functions
        ]
        cases = lesson.checks.cases(SEED)
        left = {number for number, case in enumerate(cases) if case.play is None}
        for _, _, source in own:
            if not left:
                break
            with suppress(StudentError), StudentProcess("mutant.py", source) as process:
                for number in sorted(left):
                    left -= {number} if _fails(process, lesson, cases[number]) else set()
                    if process.broken:
                        break
        idle += [f"lesson {lesson.number}: {cases[number].words.say()}" for number in left]
    return idle


def _fails(process: StudentProcess, lesson: Lesson, case: Case) -> bool:
    measured, failures = measure(process, lesson, [case])
    if failures or not measured:
        return True
    return not measured[0].passed or bool(list(lesson.checks.signs([measured[0].outcome])))


def times() -> None:
    for lesson in lessons():
        began = time.monotonic()
        grade(ARRAYS, "mine.py", lesson)
        print(f"lesson {lesson.number}: {time.monotonic() - began:.2f} s")
    began = time.monotonic()
    sources = [*CORRECT.values(), *(writing.source for writing in WRITINGS[::4])][:30]
    for source in (sources * 2)[:30]:
        for lesson in lessons()[:8]:
            grade(source, "mine.py", lesson)
    print(f"30 students, 8 lessons: {(time.monotonic() - began) / 60:.1f} min on one core")


def of_students(name: str) -> list[str]:
    """What is named otherwise than expected of a set of students' programs."""
    otherwise = []
    for program in programs(name):
        result = grade(program.source, "mine.py", lesson_of(program.lesson))
        named = [finding.cause for finding in result.findings]
        if named[:1] != ([program.cause] if program.cause else []):
            otherwise.append(f"{program.name} ({program.about}): {named}")
    return otherwise


def main(wanted: list[str]) -> int:
    if "programs" in wanted:
        for name in (*SETS, "right"):
            otherwise = of_students(name)
            print(
                f"{name}: {len(otherwise)} of {len(list(programs(name)))}", *otherwise, sep="\n  "
            )
    if "bugs" in wanted:
        share, missed = bugs()
        print(f"right cause first: {100 * share:.1f} % of {len(WRITINGS)} writings x {len(SEEDS)}")
        print(*(f"  {words} ({count})" for words, count in _counted(missed)), sep="\n")
    if "pairs" in wanted:
        share, missed = two_bugs()
        print(f"two at once, one named: {100 * share:.1f} % of {len(pairs())} pairs")
        print(*(f"  {words} ({count})" for words, count in _counted(missed)), sep="\n")
    if "correct" in wanted:
        alarms = false_alarms()
        print(f"false alarms: {len(alarms)}", *alarms, sep="\n  ")
    if "steering" in wanted:
        share, missed, alarms = steered()
        print(f"lesson 10: {100 * share:.1f} % right, false alarms: {len(alarms)}")
        print(*missed, *alarms, sep="\n  ")
    if "mutants" in wanted:
        sources = {"arrays": ARRAYS, "loops": LOOPS, "matrices": MATRICES}
        count, survivors = mutation_trial(sources)
        print(f"mutants found: {100 * (1 - len(survivors) / count):.1f} % of {count}, seed {SEED}")
        print(*(f"  {words}" for words in survivors), sep="\n")
    if "checks" in wanted:
        idle = idle_checks()
        print(f"cases that no mutant fails: {len(idle)}", *idle, sep="\n  ")
    if "times" in wanted:
        times()
    return 0


def _counted(missed: list[str]) -> list[tuple[str, int]]:
    return Counter(
        words.partition(", seed")[0] + words[words.find(":") :] for words in missed
    ).most_common(40)


if __name__ == "__main__":
    sys.exit(
        main(sys.argv[1:] or ["bugs", "pairs", "correct", "steering", "mutants", "checks", "times"])
    )

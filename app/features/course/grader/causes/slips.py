"""Slips of one line that no lesson expects: what the line needs is found by trying."""

from __future__ import annotations

from app.features.course.grader.causes.cause import Cause

SLIPS = {
    "slip-sign": Cause(
        "One term counts the wrong way.",
        "A sign is the wrong one: something is added that has to be taken away, or the other way "
        "round.",
        "Read that line aloud, term by term: which of them has to make the result larger?",
    ),
    "slip-range": Cause(
        "The first one or the last one is left out, or one too many is taken.",
        "A range begins or ends one beside where it should.",
        "range(n) gives 0 to n - 1. Which is the first one, and which the last?",
    ),
    "slip-loop": Cause(
        "It goes one step where it should go on.",
        "if asks once; what is to be done as long as it is so needs while.",
        "How often has that line to be done at most? if does it once.",
    ),
    "slip-break": Cause(
        "It goes on where it should stop.",
        "A loop is not ended where what it searches has turned up: the rounds that follow take "
        "more, or write over it.",
        "What happens in the next round after the right one? break ends a loop.",
    ),
    "slip-operator": Cause(
        "The result has another size than it should.",
        "An operator is the wrong one, as times for divided.",
        "Work out the line's units: metres, radians, shares. Do they fit?",
    ),
    "slip-brackets": Cause(
        "The numbers have the wrong size.",
        "What stands in brackets together belongs apart, or the other way round.",
        "Without brackets a + b / c is a + (b / c). What is to be taken together in that line?",
    ),
    "slip-comparison": Cause(
        "It decides the wrong way.",
        "A comparison is the wrong one.",
        "Put numbers in: one for which it has to be true, and one for which it has not.",
    ),
    "slip-function": Cause(
        "The result is another one than it should be.",
        "A function is called that does something else than is due here, as max for sum.",
        "Say in words what the line has to do with its values. Which function does that?",
    ),
    "slip-number": Cause(
        "The result has another size than it should.",
        "A number is another one than the lesson's, or an index is that of another value.",
        "Compare the numbers of that line with the stub and the text.",
    ),
    "slip-name": Cause(
        "One value stands where another one is due.",
        "A variable is the wrong one: an old value for the new one, or x for y.",
        "Follow each name of that line back to where it was set.",
    ),
    "slip-order": Cause(
        "What belongs together comes in another order.",
        "Two things are exchanged: values, lines, or what is in a loop and what is not.",
        "Compare the order with the stub's description, and say what each line needs from those "
        "before.",
    ),
    "slip-too-much": Cause(
        "The line does more than it should.",
        "There is a term, a function or a line too many.",
        "What would the result be without it? Compare with the formula, term by term.",
    ),
    "slip-missing": Cause(
        "The line does less than it should.",
        "Something is missing there, as a square, a root, or a factor.",
        "Compare with the formula, character by character.",
    ),
}

"""``brickpose learn``: each lesson begins on a field and with a filter that show its point."""

from __future__ import annotations

from app.features.course.learn_command import suited
from app.settings.config import Config, with_settings


def test_lessons_begin_with_the_filter_that_they_teach():
    assert suited(Config(), 1, map_given=False).localization.filter.filter == "particles"
    assert suited(Config(), 8, map_given=False).localization == Config().localization
    chosen = with_settings(Config(), {"localization.filter.max_particles": 700})
    assert suited(chosen, 1, map_given=False) == chosen


def test_the_lesson_of_being_found_begins_where_that_can_be():
    assert suited(Config(), 8, map_given=False).map == "stub"
    assert suited(Config(), 8, map_given=True).map == Config().map
    assert suited(Config(map="town"), 8, map_given=False).map == "town"

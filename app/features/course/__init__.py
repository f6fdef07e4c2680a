"""The course: lessons, and a grader that names the cause of a mistake."""

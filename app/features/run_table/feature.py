"""What runs add: a table beside the plot, with the numbers of each run and their differences."""

from app.feature import Feature, Late

FEATURE = Feature(
    name="run_table",
    about="lists runs with their errors and parameters, and compares them",
    messages=(Late("app.features.run_table.messages:MESSAGES"),),
    outlet=Late("app.features.run_table.outlet:RunsOutlet"),
)

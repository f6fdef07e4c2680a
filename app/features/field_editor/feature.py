"""What fields of one's own add: pictures to choose by, files that are kept, an editor, sheets."""

from app.feature import Feature, Late

FEATURE = Feature(
    name="field_editor",
    about="shows pictures of fields, keeps drawings and maps, edits tape, and prints it to scale",
    outlet=Late("app.features.field_editor.outlet:FieldEditorOutlet"),
    messages=(Late("app.features.field_editor.messages:MESSAGES"),),
)

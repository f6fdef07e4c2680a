"""What the documents add: ``/help``, with those of ours and of all features."""

from app.feature import Feature, Late

FEATURE = Feature(
    name="help",
    about="shows the documents, those of other features too, at /help",
    routers=(Late("app.features.help.documents:documents_router"),),
)

"""What the interface's page adds: ``/docs``, with all addresses and messages."""

from app.feature import Feature, Late

FEATURE = Feature(
    name="interface",
    about="describes the interface for programs, all addresses and messages, at /docs",
    routers=(Late("app.features.interface.docs_page:docs_router"),),
)

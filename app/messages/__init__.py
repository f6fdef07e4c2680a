"""Messages of the wire: telemetry out, commands in; ``type`` tells them apart.

Metres, seconds and radians; the map frame unless stated otherwise; theta from +x, anticlockwise.
Unknown keys, NaN and infinities are refused. ``python -m app.tools.typescript`` makes
``frontend/messages.d.ts`` from these and from those of the features.
"""

"""What crosses the wire: telemetry out, commands in; told apart by ``type``.

Metres, seconds and radians; the map frame unless said otherwise; theta from +x, anticlockwise.
Unknown keys, NaN and infinities are refused. ``frontend/messages.d.ts`` is made from these by
``python -m app.messages.typescript``.
"""

"""Messages as JSON and CBOR, and back."""

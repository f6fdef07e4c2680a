"""From an SVG drawing to areas on the floor, and from areas to grey levels."""

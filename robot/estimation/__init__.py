"""How far an estimate is to be believed, whatever was estimated."""

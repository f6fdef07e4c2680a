"""What runs inside JupyterHub's own process; nothing else imports it."""

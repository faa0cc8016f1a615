"""Judge answers by equations: errors, losses, and the capability of a vehicle."""

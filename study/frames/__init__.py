"""Frame sets: contacts drawn from a mixture, or a recording, in blocks that any process can make."""

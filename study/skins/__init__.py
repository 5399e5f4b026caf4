"""The study of a skin: contacts that are found or not, and the errors of those that are."""

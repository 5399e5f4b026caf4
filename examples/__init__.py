"""CONFIG and STUDY files; ``tfra examples`` lists and writes them."""

"""The page of a study: tables in, sentences and charts out."""

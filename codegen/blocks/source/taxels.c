// The taxels, row by row, of a vector in the taxel domain.

static void to_taxels(const vector_t planes[4 * QUADS], vector_t taxels[TAXELS])
{
    for (int t = 0; t < TAXELS; t++)
        taxels[t] = planes[PLACE_OF[t]];
}

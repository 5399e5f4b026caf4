// F* and the words of it that all estimators share.

typedef struct {
    scalar_t words[3]; // F* on the vector grid, times 2^exponent
    int exponent;
} resultant_t;

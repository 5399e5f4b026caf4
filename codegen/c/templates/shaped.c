// All designs of a shape.  Not for threads: there is one design at a time.
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

$fixed

static int64_t given[$count];
$given

$types

typedef struct {
$fields
} result_t;

typedef struct {
$members
    code_t stress[TAXELS];
} state_t;

$tables

$blocks
void choose(const int64_t *constants, const void *const *tables)
{
    memcpy(given, constants, sizeof given);
$chosen
}

void run(const code_t *codes, int64_t frames, int64_t *words)
{
    state_t state;
    result_t answer, *const result = &answer;
    for (int64_t frame = 0; frame < frames; frame++) {
        int place = 0;
        estimate(&state, codes + frame * TAXELS, result);
        result->frame = frame;
$gather
        words += place;
    }
}

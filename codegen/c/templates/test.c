// Checks $name against recorded frames: prints the first word that differs, and returns 1 then.
#include "$name.h"

#include <stdio.h>

enum { FRAMES = $frames, WORDS = $words };

static const ${name}_code codes[FRAMES][${NAME}_TAXELS] = {
$codes
};

static const int64_t expected[FRAMES][WORDS] = {
$expected
};

static const struct {
    int first;
    const char *name;
} fields[] = {
$names
};

static const char *field_of(int word)
{
    const char *name = "";
    for (unsigned i = 0; i < sizeof fields / sizeof *fields && fields[i].first <= word; i++)
        name = fields[i].name;
    return name;
}

static void words_of(const ${name}_result *result, int64_t words[WORDS])
{
    int place = 0;
$gather
}

int main(void)
{
    static ${name}_state state;
    static ${name}_result result;
    int64_t words[WORDS];
    if (sizeof state != $ram) {
        printf("the state takes %u bytes, $ram are stated\n", (unsigned)sizeof state);
        return 1;
    }
    ${name}_init(&state);
    for (int frame = 0; frame < FRAMES; frame++) {
        ${name}_step(&state, codes[frame], &result);
        words_of(&result, words);
        for (int word = 0; word < WORDS; word++)
            if (words[word] != expected[frame][word]) {
                printf("frame %d, word %d, %s: %lld, %lld is right\n", frame, word, field_of(word),
                       (long long)words[word], (long long)expected[frame][word]);
                return 1;
            }
    }
    printf("$name: %d frames, %d words, all right\n", FRAMES, FRAMES * WORDS);
    return 0;
}

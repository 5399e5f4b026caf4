// Checks $name on a skin against recorded frames: prints the first word that differs, and returns 1 then.
#include "${name}_skin.h"

#include <stdio.h>

enum { FRAMES = $frames, CONTACTS = $contacts, WORDS = $words };

static const ${name}_code codes[FRAMES][${NAME}_SKIN_TAXELS] = {
$codes
};

// Contacts of every frame, and peaks that are left.
static const struct {
    int found;
    int dropped;
} counts[FRAMES] = {
$counts
};

static const int64_t expected[CONTACTS][WORDS] = {
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

static void words_of(const ${name}_contact *contact, int64_t words[WORDS])
{
    const ${name}_result *result = &contact->window;
    int place = 0;
$header
$gather
}

static int wrong(const ${name}_contact *contact, int number)
{
    int64_t words[WORDS];
    words_of(contact, words);
    for (int word = 0; word < WORDS; word++)
        if (words[word] != expected[number][word]) {
            printf("contact %d, word %d, %s: %lld, %lld is right\n", number, word, field_of(word),
                   (long long)words[word], (long long)expected[number][word]);
            return 1;
        }
    return 0;
}

int main(void)
{
    static ${name}_skin skin;
    static ${name}_contact contacts[$most];
    int number = 0;
    if (sizeof skin != $ram) {
        printf("the state takes %u bytes, $ram are stated\n", (unsigned)sizeof skin);
        return 1;
    }
    ${name}_skin_init(&skin);
    for (int frame = 0; frame < FRAMES; frame++) {
        const int found = ${name}_skin_step(&skin, codes[frame], contacts);
        if (found != counts[frame].found || (int)skin.dropped != counts[frame].dropped) {
            printf("frame %d: %d contacts and %d peaks left, %d and %d are right\n", frame, found, (int)skin.dropped,
                   counts[frame].found, counts[frame].dropped);
            return 1;
        }
        for (int contact = 0; contact < found; contact++)
            if (wrong(contacts + contact, number++))
                return 1;
    }
    printf("$name on a skin: %d frames, %d contacts, all right\n", FRAMES, number);
    return 0;
}

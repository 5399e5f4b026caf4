// Frames through the Verilated core in sessions that end with a reset; every word compared with that of the core in C.
//
// sessions LIBRARY SEED RANDOM GIVEN: nine sessions, one for each pair of stalls on input and output, send all codes of the
// file GIVEN, int32, then RANDOM random frames, and are reset when idle.  Others follow, with random frames, each of which
// is reset while taxels come, while the core computes or while words leave.  Writes as JSON what was compared: in each pair
// of stalls, and after a reset in each phase.
#include "core.h"

#include <fstream>
#include <iterator>

enum { IDLE, TAXELS_COME, COMPUTING, WORDS_LEAVE, PHASES };
static const int PAIRS = 9, ROUNDS = 4;

static std::vector<char> bytes(const char *name)
{
    std::ifstream file(name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

struct Sessions {
    Ports ports;
    Random random;
    std::vector<char> given, loaded;
    i64 stalled[PAIRS] = {}, after[PHASES] = {}, words = 0, differ = 0, broken = 0, missing = 0, cycles = 0, frames = 0;

    void reset()
    {
        ports.offer(false, std::vector<CODE>(TAXELS).data(), 0, 0);
        ports.take(false);
        ports.reset(1);
        for (int cycle = 0; cycle < 4; cycle++) {
            ports.clock(0);
            ports.clock(1);
        }
        ports.reset(0);
        std::fill(state.begin(), state.end(), 0);
        records = 0;
        const unsigned *first = (const unsigned *)loaded.data();
        ports.begin(std::vector<unsigned>(first, first + loaded.size() / sizeof(unsigned)));
    }

    // A session after a reset in the phase `before`, which ends in the phase `end`, or when idle after so many frames.
    void session(int before, int pair, int end, i64 count)
    {
        const i64 directed = (i64)(given.size() / sizeof(int) / TAXELS);
        Stalls in{{random.next()}, pair % 3}, out{{random.next()}, pair / 3};
        std::deque<Frame> due;
        Frame sending{-1, std::vector<CODE>(TAXELS), {}};
        int beat = Ports::beats;
        size_t place = 0;
        bool holding = false, waiting = false;
        u64 waited = 0;
        i64 sent = 0, quiet = 0, drained = 0, delay = random.below(200 + 4 * TAXELS);
        reset();
        while (drained < 256) {
            const int phase = place                    ? WORDS_LEAVE
                              : beat % Ports::beats    ? TAXELS_COME
                              : due.empty()            ? IDLE
                              : beat == Ports::beats   ? COMPUTING
                                                       : TAXELS_COME;
            if (end && sent > 1 && phase == end && delay-- <= 0)
                return;
            if (quiet > PATIENCE) {
                missing++;
                return;
            }
            if (beat == Ports::beats && sent < count) {
                sending.number = sent++;
                sending.words.clear();
                const int *codes = (const int *)given.data() + sending.number * TAXELS;
                if (!end && sending.number < directed)
                    sending.codes.assign(codes, codes + TAXELS);
                else
                    draw(random, sending.codes);
                expect(sending);
                due.push_back(sending);
                beat = 0;
            }
            const bool offered = beat < Ports::beats && (holding || !in.now()), ready = due.empty() || !out.now();
            ports.offer(offered, sending.codes.data(), beat < Ports::beats ? beat : 0, sending.number);
            ports.take(ready);
            ports.clock(0);
            const bool valid = ports.valid(), taken = offered && ports.ready(), last = valid && ports.last();
            const u64 word = valid ? ports.word() : 0;
            broken += waiting && (!valid || word != waited);
            ports.clock(1);
            cycles++;
            beat += taken;
            holding = offered && !taken;
            waiting = valid && !ready;
            waited = word;
            quiet = taken || (valid && ready) ? 0 : quiet + 1;
            drained = due.empty() && sent == count && beat == Ports::beats ? drained + 1 : 0;
            if (due.empty()) {
                broken += valid;
            } else if (valid && ready) {
                const size_t record = Ports::head + RECORD_WORDS;
                broken += last != (place % record == record - 1);
                const bool same = word == due.front().words[place];
                differ += !same;
                words++;
                stalled[pair] += same;
                after[before] += same;
                if (++place == due.front().words.size()) {
                    due.pop_front();
                    place = 0;
                    frames++;
                }
            }
        }
    }
};

int main(int, char **arguments)
{
    void *library = dlopen(arguments[1], RTLD_NOW);
    if (!library)
        return std::fprintf(stderr, "%s\n", dlerror()), 2;
    run = (Run)dlsym(library, "run");
    static Sessions all;
    all.random.state = std::strtoull(arguments[2], nullptr, 10);
    all.given = bytes(arguments[4]);
    all.loaded = bytes("coefficients");
    const i64 random = std::atoll(arguments[3]), whole = (i64)(all.given.size() / sizeof(int) / TAXELS) + random;
    for (int pair = 0; pair < PAIRS; pair++)
        all.session(IDLE, pair, IDLE, whole);
    int before = IDLE;
    for (int round = 0; round < ROUNDS; round++)
        for (int end = TAXELS_COME; end < PHASES; end++) {
            all.session(before, (round * PHASES + end) % PAIRS, end, 1ll << 40);
            before = end;
        }
    all.session(before, PAIRS - 1, IDLE, 8);
#if VM_COVERAGE
    all.ports.top.contextp()->coveragep()->write("coverage.dat");
#endif
    std::printf("{\"stalled\": [%lld", all.stalled[0]);
    for (int pair = 1; pair < PAIRS; pair++)
        std::printf(", %lld", all.stalled[pair]);
    std::printf("], \"after\": [%lld, %lld, %lld, %lld], ", all.after[0], all.after[1], all.after[2], all.after[3]);
    std::printf("\"frames\": %lld, \"words\": %lld, \"differ\": %lld, \"broken\": %lld, \"missing\": %lld, \"cycles\": %lld}\n",
                all.frames, all.words, all.differ, all.broken, all.missing, all.cycles);
    return 0;
}

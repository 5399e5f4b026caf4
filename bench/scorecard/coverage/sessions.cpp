// Frames through the Verilated core in sessions that end with a reset; every word compared with that of the core in C.
//
// sessions LIBRARY SEED RANDOM GIVEN: nine sessions, one for each pair of stalls on input and output, send all codes of the
// file GIVEN, int32, then RANDOM random frames, and are reset when idle.  Others follow, with random frames, each of which
// is reset while taxels come, while the core computes or while words leave.  Writes as JSON what was compared: in each pair
// of stalls, and after a reset in each phase.
#include "core.h"

enum { IDLE, TAXELS_COME, COMPUTING, WORDS_LEAVE, PHASES };
static const int PAIRS = 9, ROUNDS = 4;

struct Sessions {
    Ports ports;
    Random random;
    std::vector<int> given;
    std::vector<unsigned> coefficients;
    i64 stalled[PAIRS] = {}, after[PHASES] = {}, words = 0, differ = 0, broken = 0, missing = 0, cycles = 0, frames = 0;

    // A session after a reset in the phase `before`, which ends in the phase `end`, or when idle after so many frames.
    void session(int before, int pair, int end, i64 count)
    {
        const i64 directed = (i64)given.size() / TAXELS;
        Exchange exchange{{{random.next()}, pair % 3}, {{random.next()}, pair / 3}};
        std::deque<Frame> due;
        Frame sending{-1, std::vector<CODE>(TAXELS), {}};
        bool begun = false;
        i64 drawn = 0, drained = 0, delay = random.below(200 + 4 * TAXELS);
        reset(ports);
        std::fill(state.begin(), state.end(), 0);
        records = 0;
        ports.begin(coefficients);
        while (drained < 256) {
            const int phase = exchange.place  ? WORDS_LEAVE
                              : exchange.beat ? TAXELS_COME
                              : due.empty()   ? IDLE
                              : begun         ? TAXELS_COME
                                              : COMPUTING;
            if (end && drawn > 1 && phase == end && delay-- <= 0)
                return;
            if (exchange.quiet > PATIENCE) {
                missing++;
                return;
            }
            // Every eighth frame before a reset comes to an empty core, which then computes while nothing moves.
            if (!begun && drawn < count && (!end || drawn % 8 || due.empty())) {
                begun = true;
                sending.number = drawn++;
                sending.words.clear();
                const int *codes = given.data() + sending.number * TAXELS;
                if (!end && sending.number < directed)
                    sending.codes.assign(codes, codes + TAXELS);
                else
                    draw(random, sending.codes);
                expect(sending);
                due.push_back(sending);
            }
            const size_t place = exchange.place;
            broken += exchange.cycle(ports, begun ? &sending : nullptr, due.empty() ? nullptr : &due.front());
            cycles++;
            begun &= !exchange.sent;
            drained = due.empty() && drawn == count && !begun ? drained + 1 : 0;
            if (exchange.moved) {
                const bool same = exchange.word == due.front().words[place];
                differ += !same;
                words++;
                stalled[pair] += same;
                after[before] += same;
            }
            if (exchange.ended) {
                due.pop_front();
                frames++;
            }
        }
    }
};

int main(int, char **arguments)
{
    if (!load(arguments[1]))
        return 2;
    static Sessions all;
    all.random.state = std::strtoull(arguments[2], nullptr, 10);
    all.given = items<int>(arguments[4]);
    all.coefficients = items<unsigned>("coefficients");
    const i64 whole = (i64)all.given.size() / TAXELS + std::atoll(arguments[3]);
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

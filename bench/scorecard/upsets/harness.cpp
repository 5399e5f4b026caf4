// Bits of the Verilated core flipped one at a time, and the frames that come afterwards.
//
// harness LIBRARY SEED UPSETS INTERVAL LATENCY WARNINGS: prints a line "var NAME" for every register and memory, one
// with the bits of registers, of words in memories that frames write, and of words that stay as they are after a reset,
// then one of numbers for each upset, whose second is the kind of its bit in the same order.  Every upset starts from a
// random cycle of an undisturbed run, which goes on from there afterwards.
#include "receiver.h"
#include "verilated_sym_props.h"
#include "verilated_syms.h"

#include <cstring>
#include <string>

struct Var {
    std::string name;
    char *data;
    i64 bits, words, bytes;  // bits of a word, bytes of all
    std::vector<int> kinds;  // of each word
};

struct Bit {
    size_t var;
    i64 word, bit;
};

enum { REGISTER, WRITTEN, KEPT };

enum { AGAIN_RIGHT, STAYS_WRONG, HUNG };

struct Upset {
    i64 seen = 0, effect = 0;  // the bit was flipped; state or streams were others a cycle later
    i64 number[4] = {};        // of frames that were right, told, silent
    i64 begin = 0, end = 0;    // first and last frame that was not right, from 1 on
    i64 state = AGAIN_RIGHT, healed = 1, interrupted = 0;  // healed: by a reset
};

typedef std::vector<char> State;

static std::vector<Var> vars;
static size_t bytes;
static std::vector<unsigned> coefficients;
static i64 patience;
static const i64 again = 8;  // right frames that end an upset after wrong ones

static void find()
{
    for (const auto &scope : *ports.top.contextp()->scopeNameMap()) {
        if (!scope.second->varsp())
            continue;
        for (const auto &[name, var] : *scope.second->varsp()) {
            if (!var.isPublicRW())
                continue;
            const i64 words = var.udims() ? var.unpackedRanges()[0].elements() : 1;
            vars.push_back({std::string(scope.first) + "." + name, (char *)var.datap(), var.entBits(), words,
                            (i64)var.totalSize(), std::vector<int>((size_t)words, var.udims() ? KEPT : REGISTER)});
            bytes += var.totalSize();
        }
    }
}

static State saved()
{
    State state(bytes);
    char *place = state.data();
    for (const Var &var : vars)
        place = (char *)std::memcpy(place, var.data, (size_t)var.bytes) + var.bytes;
    return state;
}

static void restore(const State &state)
{
    const char *place = state.data();
    for (const Var &var : vars) {
        std::memcpy(var.data, place, (size_t)var.bytes);
        place += var.bytes;
    }
}

static void restart()
{
    reset(ports);
#if PER_BEAT
    ports.write(0x4c, 1);                         // INTERRUPT_ENABLE.error
    ports.write(0x54, (unsigned)(patience / 2));  // FRAME_TIMEOUT
#endif
    ports.begin(coefficients);
}

// Whether so many frames come, and all of them are right.
static bool works(Streams &line, int count)
{
    while (count > 0 && line.quiet < patience) {
        const int found = step(line);
        if (found > RIGHT)
            return false;
        count -= found == RIGHT;
    }
    return count == 0;
}

// Tell words of memories that frames write from those that stay as they are after a reset.
static bool divide(Streams &golden)
{
    const State first = saved();
    bool sound = true;
    for (int count = 0; count < 40; count++) {
        sound &= works(golden, 1);
        const char *place = first.data();
        for (Var &var : vars) {
            const size_t size = (size_t)(var.bytes / var.words);
            for (size_t word = 0; word < var.kinds.size(); word++, place += size)
                if (var.kinds[word] == KEPT && std::memcmp(place, var.data + word * size, size))
                    var.kinds[word] = WRITTEN;
        }
    }
    return sound;
}

static Upset observe(const Streams &golden, const Bit &flip)
{
    Upset found;
    const State now = saved();
    Streams line = golden;
    step(line);
    const State next = saved();
    const std::vector<u64> words = line.got;
    restore(now);
    line = golden;
    const Var &var = vars[flip.var];
    char &byte = var.data[flip.word * (var.bytes / var.words) + flip.bit / 8];
    const int before = byte;
    byte = (char)(before ^ 1 << flip.bit % 8);
    ports.top.eval();
    found.seen = ((byte ^ before) >> flip.bit % 8) & 1;
    const i64 most = golden.sending - golden.due + 3;  // frames that can know of the upset, and two more
    i64 count = 0, cycle = 0;
    while (line.quiet < patience && count < most + 30 && (count < most || (found.end && count < found.end + again))) {
        const i64 due = line.due;
        const int verdict = step(line);
        if (!cycle++)
            found.effect = saved() != next || words != line.got;
        found.number[verdict]++;
        count += line.due - due;  // with those that are lost
        if (verdict > RIGHT) {
            found.begin = found.begin ? found.begin : count;
            found.end = count;
        }
    }
    const bool wrong = found.end && count < found.end + again;
    found.state = line.quiet >= patience ? HUNG : wrong ? STAYS_WRONG : AGAIN_RIGHT;
    found.interrupted = interrupt();
    if (found.state != AGAIN_RIGHT) {
        Streams fresh;
        restart();
        found.healed = works(fresh, 4);
    }
    restore(now);
    return found;
}

int main(int, char **arguments)
{
    if (!load(arguments[1]))
        return 2;
    Random random{drawing.state = std::strtoull(arguments[2], nullptr, 10)};
    const i64 upsets = std::atoll(arguments[3]);
    interval = std::atoll(arguments[4]);
    latency = std::atoll(arguments[5]);
    warnings = std::strtoull(arguments[6], nullptr, 10);
    patience = 1000 + 8 * (interval + latency);
    coefficients = items<unsigned>("coefficients");
    find();
    restart();
    Streams golden;
    bool sound = divide(golden);
    std::vector<Bit> bits[3];
    for (size_t var = 0; var < vars.size(); var++) {
        const Var &one = vars[var];
        std::printf("var %s\n", one.name.c_str());
        for (i64 place = 0; place < one.words * one.bits; place++)
            bits[one.kinds[(size_t)(place / one.bits)]].push_back({var, place / one.bits, place % one.bits});
    }
    std::printf("bits %zu %zu %zu\n", bits[REGISTER].size(), bits[WRITTEN].size(), bits[KEPT].size());
    for (i64 upset = 0, turn = 0; upset < upsets && !bits[0].empty(); upset++) {
        golden.quiet = 0;
        for (i64 cycles = random.below(interval) + 1; cycles--;)
            sound &= step(golden) <= RIGHT;
        int kind = upset % 8 == 6 ? WRITTEN : upset % 8 == 7 ? KEPT : REGISTER;
        if (bits[kind].empty())
            kind = REGISTER;
        std::vector<Bit> &all = bits[kind];
        const size_t place = kind ? 0 : (size_t)turn++ % all.size();  // each register in turn, in a random order
        std::swap(all[place], all[place + (size_t)random.below((i64)(all.size() - place))]);
        const Upset found = observe(golden, all[place]);
        std::printf("%zu %d %lld %lld %lld %lld %lld %lld %lld %lld\n", all[place].var, kind, found.seen, found.effect,
                    found.number[TOLD], found.number[SILENT], found.end ? found.end - found.begin + 1 : 0, found.state,
                    found.healed, found.interrupted);
    }
    std::printf("sound %d\n", sound);
    return 0;
}

// The Verilated core, alone or behind AXI, the frames that are sent to it, and the words that it has to send.
#pragma once
#include "Vtop.h"
#include "shape.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <dlfcn.h>
#include <vector>

typedef unsigned long long u64;
typedef long long i64;

static const i64 low = -(1ll << (CODE_BITS - 1)), high = -low - 1;
static const int bits = PER_BEAT ? 32 : WORD_BITS;  // AXI extends words by their sign
static const u64 mask = bits == 64 ? ~0ull : (1ull << bits) - 1;

struct Random {
    u64 state;
    u64 next()
    {
        u64 z = state += 0x9e3779b97f4a7c15ull;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
        return z ^ (z >> 31);
    }
    i64 below(i64 n) { return (i64)((next() >> 11) % (u64)n); }
    double real(double from, double to) { return from + (to - from) * (double)(next() >> 11) / 9007199254740992.0; }
    double normal() { return (real(-1, 1) + real(-1, 1) + real(-1, 1)); }
};

// The ports of a core, or of one behind AXI.
struct Ports {
    Vtop top;
#if PER_BEAT
    static const int beats = (TAXELS + PER_BEAT - 1) / PER_BEAT, head = 2;
    bool ready() { return top.s_axis_tready; }
    bool valid() { return top.m_axis_tvalid; }
    bool last() { return top.m_axis_tlast; }
    u64 word() { return (u64)top.m_axis_tdata; }
    void take(bool ready) { top.m_axis_tready = ready; }
    void clock(int level) { top.aclk = level; top.eval(); }
    void reset(int level)
    {
        top.aresetn = !level;
        SETTINGS
    }
    void offer(bool valid, const CODE *codes, int beat, i64 frame)
    {
        u64 data = 0;
        for (int place = PER_BEAT - 1; place >= 0; place--) {
            const int taxel = beat * PER_BEAT + place;
            data = data << 16 | (taxel < TAXELS ? (u64)codes[taxel] & 0xffff : 0);
        }
        top.s_axis_tvalid = valid;
        top.s_axis_tdata = data;
        top.s_axis_tuser = frame & 0xffff;
        top.s_axis_tlast = beat == beats - 1;
    }
    void write(int address, unsigned value)
    {
        bool put_address = true, put_data = true;
        top.s_axi_bready = 1;
        for (bool answered = false; !answered;) {
            top.s_axi_awaddr = address;
            top.s_axi_wdata = value;
            top.s_axi_wstrb = 15;
            top.s_axi_awvalid = put_address;
            top.s_axi_wvalid = put_data;
            clock(0);
            answered = top.s_axi_bvalid;
            const bool address_taken = top.s_axi_awready, data_taken = top.s_axi_wready;
            clock(1);
            put_address &= !address_taken;
            put_data &= !data_taken;
        }
    }
    void begin(const std::vector<unsigned> &coefficients)
    {
        if (LOADED)
            write(0x88, CHECKSUM);
        for (unsigned word : coefficients)
            write(0x80, word);
        write(0x40, CONTROL);
    }
#else
    static const int beats = TAXELS, head = 0;
    bool ready() { return top.taxel_ready; }
    bool valid() { return top.result_valid; }
    bool last() { return top.result_last; }
    u64 word() { return (u64)top.result_data & mask; }
    void take(bool ready) { top.result_ready = ready; }
    void clock(int level) { top.clk = level; top.eval(); }
    void reset(int level)
    {
        top.rst = level;
        SETTINGS
    }
    void offer(bool valid, const CODE *codes, int beat, i64)
    {
        top.taxel_valid = valid;
        top.taxel_data = (u64)codes[beat] & ((1ull << CODE_BITS) - 1);
    }
    void begin(const std::vector<unsigned> &coefficients)
    {
#if LOADED
        for (unsigned word : coefficients) {
            top.load_valid = 1;
            top.load_data = word;
            for (bool taken = false; !taken;) {
                clock(0);
                taken = top.load_ready;
                clock(1);
            }
        }
        top.load_valid = 0;
#endif
    }
#endif
};

struct Stalls {
    Random random;
    int kind = 0, left = 0;
    bool silent = false;
    void choose() { kind = (int)random.below(5); }  // 0: random, 1: bursts, others: none
    bool now()
    {
        if (kind == 0)
            return random.next() & 1;
        if (kind > 1)
            return false;
        if (left-- <= 0) {
            left = (int)random.below(29);
            silent = !silent;
        }
        return silent;
    }
};

struct Frame {
    i64 number;
    std::vector<CODE> codes;
    std::vector<u64> words;
};

typedef i64 (*Run)(void *, const CODE *, i64, i64 *);
static Run run;
static std::vector<i64> state((STATE_BYTES + 7) / 8), made(MOST *RECORD_WORDS);
static i64 records;

static void press(Random &random, std::vector<CODE> &codes, double noise)
{
    const double size = std::exp2(random.real(3, CODE_BITS - 1)), tangent = random.real(-1, 1);
    const double turn = random.real(0, 6.2832), row = random.real(0, ROWS - 1), column = random.real(0, COLUMNS - 1);
    const double wide = random.real(0.4, 0.5 * (ROWS + COLUMNS));
    for (int taxel = 0; taxel < TAXELS; taxel++) {
        const double y = (taxel / COLUMNS - row) / wide, x = (taxel % COLUMNS - column) / wide;
        const double pressed = std::exp(-x * x - y * y) * (1 + tangent * (x * std::cos(turn) + y * std::sin(turn)));
        const double code = std::rint(-size * pressed + noise * random.normal());
        codes[taxel] = (CODE)std::fmin(std::fmax(code, (double)low), (double)high);
    }
}

static void draw(Random &random, std::vector<CODE> &codes)
{
    const i64 corners[] = {low, high, 0, -1, 1, low + 1, high - 1, random.below(high - low + 1) + low};
    const i64 kind = random.below(20), size = 1ll << random.below(CODE_BITS);
    const double share = random.real(0.05, 1);
    if (kind < 9)
        return press(random, codes, kind < 5 ? random.real(0, 4) : 0);
    const i64 rest = random.below(3) ? 0 : corners[random.below(8)];
    for (CODE &code : codes) {
        const bool other = random.real(0, 1) < share;
        const double noise = std::fmin(std::fmax(std::rint(random.normal() * size), (double)low), (double)high);
        if (kind < 14)
            code = other ? (CODE)noise : 0;
        else if (kind < 17)
            code = (CODE)corners[random.below(8)];
        else
            code = (CODE)(random.real(0, 1) < 2.0 / TAXELS ? corners[random.below(8)] : rest);
    }
}

// The words that the core has to send for the frame.
static void expect(Frame &frame)
{
    const i64 count = run(state.data(), frame.codes.data(), 1, made.data());
    bool saturated = false;
    for (CODE code : frame.codes)
        saturated |= code == low || code == high;
    for (i64 record = 0; record < count; record++) {
        i64 *words = made.data() + record * RECORD_WORDS;
        words[0] = frame.number & COUNTER;
        words[HEADER] = records++ & COUNTER;
        if (Ports::head) {
            frame.words.push_back((u64)((frame.number & 0xffff) | (frame.number & 0xffff) << 16));
            frame.words.push_back((u64)saturated << 2 | 1 << 24);
        }
        for (int place = 0; place < RECORD_WORDS; place++)
            frame.words.push_back((u64)words[place] & mask);
    }
}

// The core in C; whether its library is there.
static bool load(const char *library)
{
    void *opened = dlopen(library, RTLD_NOW);
    if (!opened)
        std::fprintf(stderr, "%s\n", dlerror());
    else
        run = (Run)dlsym(opened, "run");
    return opened;
}

// All items of a file; none if it is not there.
template <typename Item> static std::vector<Item> items(const char *name)
{
    std::vector<Item> found;
    Item item;
    if (FILE *file = std::fopen(name, "rb")) {
        while (std::fread(&item, sizeof item, 1, file) == 1)
            found.push_back(item);
        std::fclose(file);
    }
    return found;
}

static const std::vector<CODE> none(TAXELS);

static void reset(Ports &ports)
{
    ports.offer(false, none.data(), 0, 0);
    ports.take(false);
    ports.reset(1);
    for (int cycle = 0; cycle < 4; cycle++) {
        ports.clock(0);
        ports.clock(1);
    }
    ports.reset(0);
}

// Both streams of a core between two cycles.
struct Exchange {
    Stalls in, out;
    int beat = 0;      // of the frame that is sent
    size_t place = 0;  // of the next word, in the frame that is due
    i64 quiet = 0;     // cycles without a transfer
    u64 word = 0;
    bool holding = false, waiting = false;
    bool sent = false, moved = false, ended = false;  // in the last cycle: a frame, a word, all words of a frame

    // A cycle, in which `sending` is offered and a word of `due` expected; null: there is none.  Returns how often a rule
    // of the streams was broken.
    int cycle(Ports &ports, const Frame *sending, const Frame *due)
    {
        const size_t record = Ports::head + RECORD_WORDS;
        const bool offered = sending && (holding || !in.now()), ready = !due || !out.now();
        ports.offer(offered, sending ? sending->codes.data() : none.data(), beat, sending ? sending->number : 0);
        ports.take(ready);
        ports.clock(0);
        const bool valid = ports.valid(), taken = offered && ports.ready(), last = valid && ports.last();
        const u64 waited = word;
        word = valid ? ports.word() : 0;
        int broken = (waiting && (!valid || word != waited)) + (valid && !due);
        ports.clock(1);
        holding = offered && !taken;
        waiting = valid && !ready;
        moved = valid && ready && due;
        quiet = taken || (valid && ready) ? 0 : quiet + 1;
        beat += taken;
        sent = beat == Ports::beats;
        beat = sent ? 0 : beat;
        if (moved)
            broken += last != (place % record == record - 1);
        place += moved;
        ended = moved && place == due->words.size();
        place = ended ? 0 : place;
        return broken;
    }
};

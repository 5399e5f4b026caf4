// Frames that go to the core, and a receiver that knows no right words, but counts what comes.
#pragma once
#include "core.h"

static const size_t frame_words = Ports::head + RECORD_WORDS;
static Random drawing{0};
static std::vector<Frame> frames;
static Ports ports;
static i64 interval, latency;  // cycles from frame to frame, and from the first taxel to the last word
static u64 warnings;           // bits of the status that tell to doubt a frame

// The state of both streams between two cycles.
struct Streams {
    Stalls in{{1}}, out{{2}};
    Random random{3};
    i64 sending = 0, due = 0, pause = 0, quiet = 0;  // frames, and cycles
    int beat = 0;
    bool spaced = false, holding = false, lost = false, interrupted = false;
    u64 number = ~0ull, head = ~0ull;  // of the frame before: that of the core, those behind AXI
    std::vector<u64> got;
};

enum { NONE, RIGHT, TOLD, SILENT };

static const Frame &frame(i64 number)
{
    while ((i64)frames.size() <= number) {
        Frame next{(i64)frames.size(), std::vector<CODE>(TAXELS), {}};
        do {  // behind AXI no frame saturates, so that every error is one of an upset
            next.words.clear();
            draw(drawing, next.codes);
            expect(next);
        } while (Ports::head && ((next.words[1] & 4) || (next.words.back() & 96)));
        frames.push_back(next);
    }
    return frames[(size_t)number];
}

static bool interrupt()
{
#if PER_BEAT
    return ports.top.irq;
#else
    return false;
#endif
}

static bool follows(u64 before, u64 now, int place) { return (((now >> place) - (before >> place)) & 0xffff) == 1; }

// A frame of the right length with the next number, no fault, new warning or interrupt tells nothing.
static int judge(Streams &line)
{
    const std::vector<u64> &got = line.got;
    bool told = got.size() != frame_words, right = false;
    if (!told) {
        const u64 number = got[Ports::head], head = got[0];
        told = !follows(line.number, number, 0) || number >> 16;
        told |= Ports::head && !(follows(line.head, head, 0) && follows(line.head, head, 16));
        line.number = number;
        line.head = head;
        const i64 most = told || line.lost ? 8 : 1;  // who was told that frames are missing takes a later one, too
        for (i64 ahead = 0; !right && ahead < most; ahead++) {
            const std::vector<u64> &words = frame(line.due + ahead).words;
            right = std::equal(got.begin() + Ports::head + 1, got.end(), words.begin() + Ports::head + 1);
            line.due += right ? ahead : 0;
        }
        const std::vector<u64> &words = frame(line.due).words;
        told |= Ports::head && got[1] != words[1];
        told |= (got.back() & ~words.back() & warnings) != 0;
    }
    told |= interrupt() && !(right && line.interrupted);
    line.interrupted = interrupt();
    line.lost = !right && (told || line.lost);
    line.due++;
    line.got.clear();
    return told ? TOLD : right ? RIGHT : SILENT;
}

// A cycle; returns how the frame was whose last word came in it.
static int step(Streams &line)
{
    bool offered = line.holding;
    if (line.beat == 0 && line.pause > 0)
        line.pause--;
    else if (!offered)
        offered = !line.in.now();
    const bool ready = !line.out.now();
    ports.offer(offered, frame(line.sending).codes.data(), line.beat, line.sending);
    ports.take(ready);
    ports.clock(0);
    const bool valid = ports.valid(), taken = offered && ports.ready(), last = ports.last();
    const u64 word = ports.word();
    ports.clock(1);
    line.holding = offered && !taken;
    line.beat += taken;
    if (line.beat == Ports::beats) {
        line.beat = 0;
        if (++line.sending % 16 == 0) {
            line.in.choose();
            line.out.choose();
            line.spaced = line.random.below(3) == 0;
        }
        line.pause = line.spaced ? line.random.below(2 * latency) : 0;
    }
    line.quiet++;
    if (!valid || !ready)
        return NONE;
    line.quiet = 0;
    line.got.push_back(word);
    return last || line.got.size() > 2 * frame_words ? judge(line) : NONE;
}

// Which mutants of a Verilated core send other words than the core in C, break the rules of their streams, or move words
// in other cycles than the original.
//
// mutants LIBRARY SEED FRAMES GIVEN NUMBER...: each sends frames until resets cut them, then the codes of the file GIVEN,
// int32, and random FRAMES, with stalls on both ports; prints the numbers of those that nothing was noticed of.
#include "core.h"

#include <memory>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

static const int cuts = 6, seconds = 60;  // resets amid frames; of CPU time, for mutants that never answer
static std::vector<Frame> frames;
static std::vector<unsigned> coefficients;
static std::vector<int> moves;  // what moved at both ports of the original, cycle by cycle
static size_t compared = 0;     // of these cycles
static bool recording = true;   // the original runs

// Whether a word is wrong, missing, too many or at another time in so many cycles after a reset; all frames are sent
// without a limit.
static bool wrong(Ports &ports, Random &random, i64 cycles)
{
    Exchange exchange{{{random.next()}}, {{random.next()}}};
    size_t sending = 0, due = 0;
    i64 drained = 0;
    reset(ports);
    ports.begin(coefficients);
    for (i64 cycle = 0; drained < 256 && (!cycles || cycle < cycles); cycle++) {
        if (sending % 64 == 0 && exchange.beat == 0) {
            exchange.in.choose();
            exchange.out.choose();
        }
        const bool left = sending < frames.size(), begun = due < sending + left;
        const size_t place = exchange.place;
        if (exchange.cycle(ports, left ? &frames[sending] : nullptr, begun ? &frames[due] : nullptr))
            return true;
        if (exchange.moved && exchange.word != frames[due].words[place])
            return true;
        const int moved = exchange.beat << 3 | exchange.holding << 2 | exchange.waiting << 1 | exchange.moved;
        if (recording)
            moves.push_back(moved);
        else if (moves[compared++] != moved)
            return true;
        due += exchange.ended;
        sending += exchange.sent;
        drained = begun ? 0 : drained + 1;
        if (begun && exchange.quiet > PATIENCE)
            return true;
    }
    return false;
}

static bool noticed(int mutant, u64 seed)
{
    Random random{seed};
    const auto ports = std::make_unique<Ports>();
    ports->top.mutant = mutant;
    for (int cut = 0; cut < cuts; cut++)
        if (wrong(*ports, random, 1 + random.below(CUT)))
            return true;
    return wrong(*ports, random, 0);
}

int main(int count, char **arguments)
{
    if (!load(arguments[1]))
        return 2;
    const u64 seed = std::strtoull(arguments[2], nullptr, 10);
    const std::vector<int> given = items<int>(arguments[4]);
    const i64 directed = (i64)given.size() / TAXELS, all = directed + std::atoll(arguments[3]);
    coefficients = items<unsigned>("coefficients");
    Random random{seed};
    for (i64 number = 0; number < all; number++) {
        Frame frame{number, std::vector<CODE>(TAXELS), {}};
        if (number < directed)
            frame.codes.assign(given.begin() + number * TAXELS, given.begin() + (number + 1) * TAXELS);
        else
            draw(random, frame.codes);
        expect(frame);
        frames.push_back(frame);
    }
    noticed(0, seed);
    recording = false;
    for (int place = 5; place < count; place++) {
        if (const pid_t child = fork()) {
            int status = 0;
            waitpid(child, &status, 0);
            if (WIFEXITED(status) && WEXITSTATUS(status) == 0)
                std::printf("%s\n", arguments[place]);
        } else {
            const rlimit limit{seconds, seconds};
            setrlimit(RLIMIT_CPU, &limit);
            std::fclose(stderr);
            _exit(noticed(std::atoi(arguments[place]), seed));
        }
    }
    return 0;
}

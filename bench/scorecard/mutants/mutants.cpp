// Which mutants of a Verilated core send other words than the core in C, or break the rules of their streams.
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

// Whether a word is wrong, missing or too many in so many cycles after a reset; all frames are sent without a limit.
static bool wrong(Ports &ports, Random &random, i64 cycles)
{
    const std::vector<CODE> none(TAXELS);
    Stalls in{{random.next()}}, out{{random.next()}};
    size_t sending = 0, due = 0, place = 0;
    int beat = 0;
    bool holding = false, waiting = false;
    u64 waited = 0;
    i64 quiet = 0, drained = 0;
    ports.offer(false, none.data(), 0, 0);
    ports.take(false);
    ports.reset(1);
    for (int cycle = 0; cycle < 4; cycle++) {
        ports.clock(0);
        ports.clock(1);
    }
    ports.reset(0);
    ports.begin(coefficients);
    for (i64 cycle = 0; drained < 256 && (!cycles || cycle < cycles); cycle++) {
        if (sending % 64 == 0 && beat == 0) {
            in.choose();
            out.choose();
        }
        const bool left = sending < frames.size(), offered = left && (holding || !in.now());
        const bool begun = due < sending + left, ready = !begun || !out.now();
        ports.offer(offered, left ? frames[sending].codes.data() : none.data(), beat, (i64)sending);
        ports.take(ready);
        ports.clock(0);
        const bool valid = ports.valid(), taken = offered && ports.ready(), moved = valid && ready;
        const u64 word = valid ? ports.word() : 0;
        if ((waiting && (!valid || word != waited)) || (valid && !begun))
            return true;
        if (moved) {
            const std::vector<u64> &words = frames[due].words;
            const size_t record = Ports::head + RECORD_WORDS;
            if (word != words[place] || ports.last() != (place % record == record - 1))
                return true;
            if (++place == words.size()) {
                place = 0;
                due++;
            }
        }
        ports.clock(1);
        holding = offered && !taken;
        waiting = valid && !ready;
        waited = word;
        quiet = taken || moved ? 0 : quiet + 1;
        drained = begun ? 0 : drained + 1;
        if (begun && quiet > PATIENCE)
            return true;
        if (taken && ++beat == Ports::beats) {
            beat = 0;
            sending++;
        }
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
    void *library = dlopen(arguments[1], RTLD_NOW);
    if (!library)
        return std::fprintf(stderr, "%s\n", dlerror()), 2;
    run = (Run)dlsym(library, "run");
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

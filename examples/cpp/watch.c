/* watch_c ARM < rows: as watch.cpp, through the C interface. */
#include <rankdrop/monitor.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arms.h"

enum { MOST = 64 };

static void print(const double* values, int count)
{
    for (int i = 0; i < count; ++i) printf(" %.17g", values[i]);
}

int main(int count, char** words)
{
    const rankdrop_arm* arm = NULL;
    for (size_t i = 0; i < sizeof arms / sizeof arms[0]; ++i)
        if (count == 2 && strcmp(arms[i]->name, words[1]) == 0) arm = arms[i];
    rankdrop_monitor* monitor = arm && arm->variables <= MOST ? rankdrop_monitor_new(arm) : NULL;
    if (!monitor) {
        fprintf(stderr, "usage: watch_c ARM < rows\n");
        return 2;
    }
    const int n = arm->variables, m = arm->rows;
    double both[2 * MOST], away[MOST], distance, residual;
    int got = 0;
    while (scanf("%lf", &both[got]) == 1) {
        if (++got < 2 * n) continue;
        got = 0;
        rankdrop_step seen;
        rankdrop_monitor_step(monitor, both, both + n, &seen);
        printf("%s %s %d %d", seen.nearest < 0 ? "none" : arm->ids[seen.nearest],
               seen.family < 0 ? "none" : arm->ids[seen.family], seen.rank, seen.corank);
        const double numbers[] = {seen.residual, seen.distance,     seen.approach,
                                  seen.scaling,  seen.rate_scaling, seen.null_rate,
                                  rankdrop_monitor_at_least(monitor, both)};
        print(numbers, 7);
        print(seen.sigma, m < n ? m : n), print(seen.u, m * m), print(seen.null_step, n);
        for (int f = 0; rankdrop_monitor_family(monitor, f, &distance, &residual, away); ++f)
            print(&distance, 1), print(&residual, 1), print(away, n);
        printf("\n");
    }
    rankdrop_monitor_free(monitor);
    return 0;
}

/* Watches one arm in a control loop: C interface. The arm comes from `rankdrop monitor ROBOT --header arm.h`, the
 * functions from `monitor_c.cpp` beside this file (CMake: rankdrop::monitor_c). No function throws, and after
 * rankdrop_monitor_new none but rankdrop_monitor_at_least allocates. One monitor serves one thread at a time. */
#ifndef RANKDROP_MONITOR_H
#define RANKDROP_MONITOR_H

#ifdef __cplusplus
extern "C" {
#endif

#define RANKDROP_ARM_FORMAT 3

/* An arm, its task and its families, as Python wrote them. Angles in rad, lengths in the arm's unit. Where one thing has
 * several others, `first_x` holds where those of each begin, and the end. */
typedef struct rankdrop_arm {
    int format; /* RANKDROP_ARM_FORMAT of the writer */
    const char* name;
    /* the chain */
    int joints, variables;
    const double* screws;     /* (joints, 6) at q = 0, linear part first */
    const int* turns;         /* (joints) 0 for slides */
    const double* frames;     /* (joints + 2, 12) base, links, tip at q = 0: rotation by rows, then translation */
    const int* variable;      /* (joints) which entry of q drives it */
    const double *multiplier, *offset; /* (joints) joint value = multiplier q + offset */
    const char* const* variable_names; /* (variables) in the order of q */
    /* the task */
    int rows, axes, origin;   /* links: 0 base ... joints + 1 tip */
    const double* point;      /* (3) in the frame of link origin */
    const int* row;           /* (rows) of (v; w) */
    const double* factor;     /* (rows) 1 over the length scale, or 1 */
    /* the families: those with conditions, those first that are preferred; `listed` counts all of Python's monitor */
    int families, listed, angles, terms, equations;
    const char *const *ids, *const *names; /* (listed) in the order of Python's `Monitor.families` */
    const int* number;        /* (families) place of each in that order, by which steps name them */
    const int* corank;        /* (families) */
    const double* shift;      /* (angles) angle = sum of m q - shift */
    const int *first_turn, *turning; /* joints that turn each angle */
    const double* m;
    const int* angle;         /* (terms) */
    const double *cosine, *sine; /* (terms) coefficients */
    const int* powers;        /* (terms, variables) of q */
    const int *first_term, *coupled; /* equations; coupled 0: said by pinned joints alone */
    const int* first_equation; /* families */
    const int *first_pin, *pinned; /* pinned joints of families */
    const int* first_value;   /* of pinned joints */
    const double* values;
    const double* scale;      /* (variables) 1, or the length scale */
    const int* periodic;      /* (variables) a turn is no motion */
    /* settings */
    int generic_rank;
    double singular, on, loose; /* tolerances */
    double start, stop;       /* motion towards a family is slowed nearer than the first, stopped nearer than the second */
    int beyond;               /* 1: not every family has conditions, the slope of sigma counts as well */
    const double* rates;      /* (variables) largest joint rates, HUGE_VAL for none */
    /* ways to look at the arm for rankdrop_monitor_at_least; none where nothing can be proven */
    int bounds, bound_rows;
    const int *bound_row, *bound_link; /* (bound_rows) of (v; w); (bounds) joints before the link */
    const double* bound_point; /* (bounds, 3) in the frame of that link */
    const double* bound_length; /* (bounds) translation rows are divided by it */
    const double* bound_reach; /* (bounds, joints) from each axis to the point */
    double bound_repeats;     /* root of the largest number of joints that one variable drives */
} rankdrop_arm;

/* What is seen at one configuration. Pointers stay valid until the monitor's next step. Numbers of families
 * are those of Python's `Monitor.families`: -1 none. */
typedef struct rankdrop_step {
    int rank, corank;       /* corank: generic rank less rank */
    int family;             /* the one the configuration lies on */
    int nearest;            /* the one that the smallest motion reaches */
    double residual;        /* |f|/|grad f| of family, or of nearest [rad] */
    double distance;        /* to nearest [rad]; where `beyond`, sigma over its slope if that is smaller */
    double approach;        /* share of the motion that leads towards nearest, -1 to 1 */
    double scaling;         /* 0 to 1: what the motion is to be multiplied by; 1 for every motion that leads away */
    double rate_scaling;    /* 0 to 1: the same, for the joint rates to keep their limits */
    double null_rate;       /* 0 to 1: share of null_step that leads away from nearest */
    const double* sigma;    /* (min(rows, variables)) descending */
    const double* u;        /* (rows, rows) by rows; columns: directions of the task, the last rows - rank are lost */
    const double* null_step; /* (variables) unit internal motion away from nearest; zeros where there is none */
} rankdrop_step;

typedef struct rankdrop_monitor rankdrop_monitor;

/* NULL where the arm is of another format or not sound, or memory is short. */
rankdrop_monitor* rankdrop_monitor_new(const rankdrop_arm* arm);
void rankdrop_monitor_free(rankdrop_monitor* monitor);
/* q and velocity have as many entries as the arm has variables; velocity may be NULL for none. Returns 1, or 0 where one
 * of them is not finite: then `out` says rank -1 and scaling 0. */
int rankdrop_monitor_step(rankdrop_monitor* monitor, const double* q, const double* velocity, rankdrop_step* out);
/* A radius around q within which no configuration is singular, of a known family or not [rad]: proven, by enclosures that
 * take some hundred times as long as a step, and memory. 0 where nothing is proven, q is not finite, or memory is short. */
double rankdrop_monitor_at_least(const rankdrop_monitor* monitor, const double* q);
/* Of one family at the last step: its distance and residual [rad], and `away` (variables), the gradient of the distance by q.
 * All are NaN for a family without conditions. Returns 1, or 0 for a number that is no family's. */
int rankdrop_monitor_family(const rankdrop_monitor* monitor, int family, double* distance, double* residual, double* away);

#ifdef __cplusplus
}
#endif
#endif

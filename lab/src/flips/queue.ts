// A queue of jobs for several runners, each with one job at a time.

export interface Queue<Job, Done> {
  run(job: Job): Promise<Done>;
  /** Drops the jobs that have not started. */
  forget(): void;
}

/** A runner that has failed gets no more jobs. */
export function queue<Job, Done>(runners: readonly ((job: Job) => Promise<Done>)[]): Queue<Job, Done> {
  interface Waiting { job: Job; resolve: (done: Done) => void; reject: (error: unknown) => void }
  const idle = [...runners];
  let waiting: Waiting[] = [];
  const next = (): void => {
    const runner = waiting.length > 0 ? idle.pop() : undefined;
    if (runner === undefined) return;
    const { job, resolve, reject } = waiting.shift()!;
    runner(job).then((done) => {
      idle.push(runner);
      resolve(done);
      next();
    }, reject);
  };
  return {
    run: (job) => new Promise((resolve, reject) => {
      waiting.push({ job, resolve, reject });
      next();
    }),
    forget() {
      waiting = [];
    },
  };
}

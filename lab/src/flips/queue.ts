// Jobs in the order they come, for several runners that each do one at a time.

export interface Queue<Job, Done> {
  run(job: Job): Promise<Done>;
  /** What has not been begun is not done. */
  forget(): void;
}

/** A runner that fails is not asked again. */
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

declare module "*.nc" {
  const text: string;
  export default text;
}
declare module "*.apt" {
  const text: string;
  export default text;
}
declare module "*.json" {
  const value: unknown;
  export default value;
}
